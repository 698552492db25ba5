//! XML as people write it for robots: with prefixes that are not declared, and with blank lines or comments before the
//! declaration. Other readers of URDF know neither namespaces nor the rule that a declaration comes first.

use super::elements::Read;
use super::{LoadNote, LoadReport};
use roxmltree::{Document, Error as XmlError, Node};
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::ops::Range;

/// The largest number of prefixes that are declared for a text which does not: each takes another reading of it.
const MAX_PREFIXES: usize = 64;

/// The text with its prefixes declared in the root element, and with spaces in place of a declaration that is not at
/// the beginning, so that lines keep their numbers. A text with other faults is returned with these.
pub(super) fn mended(text: &str) -> (Cow<'_, str>, LoadReport) {
    let (mut mended, mut notes) = (Cow::Borrowed(text), LoadReport::new());
    let mut declared = BTreeSet::new();
    loop {
        let fault = Document::parse(&mended).err();
        let Prolog { declaration, root } = Prolog::of(&mended);
        match (fault, declaration, root) {
            (Some(XmlError::UnknownNamespace(prefix, _)), _, Some(root))
                if declared.len() < MAX_PREFIXES && declared.insert(prefix.clone()) =>
            {
                let declaration = format!(" xmlns:{prefix}=\"undeclared:{prefix}\"");
                mended.to_mut().insert_str(root, &declaration);
                notes.push(LoadNote::UndeclaredPrefix { prefix });
            }
            (Some(XmlError::UnexpectedDeclaration(_)), Some(range), _) if range.start > 0 => {
                let blank = |c: char| if c == '\n' { "\n" } else { " " };
                let blank: String = mended[range.clone()].chars().map(blank).collect();
                mended.to_mut().replace_range(range, &blank);
                notes.push(LoadNote::BeforeDeclaration);
            }
            _ => return (mended, notes),
        }
    }
}

/// The text before the root element.
struct Prolog {
    /// The first declaration `<?xml ... ?>`.
    declaration: Option<Range<usize>>,
    /// The end of the name of the root element.
    root: Option<usize>,
}

impl Prolog {
    fn of(text: &str) -> Self {
        let (mut at, mut declaration) = (0, None);
        let root = loop {
            let Some(start) = text[at..].find('<').map(|found| at + found) else {
                break None;
            };
            let rest = &text[start..];
            let end = match rest {
                comment if comment.starts_with("<!--") => "-->",
                instruction if instruction.starts_with("<?") => "?>",
                element => {
                    let is_end = |c: char| c.is_whitespace() || matches!(c, '/' | '>');
                    break element.find(is_end).map(|length| start + length);
                }
            };
            let Some(length) = rest.find(end).map(|found| found + end.len()) else {
                break None;
            };
            at = start + length;
            if rest.starts_with("<?xml ") {
                declaration.get_or_insert(start..at);
            }
        };
        Self { declaration, root }
    }
}

/// The elements within an element, without those with a prefix, which are for other programs.
pub(super) fn elements<'a, 'input>(node: Node<'a, 'input>) -> impl Iterator<Item = Node<'a, 'input>> {
    let own = |child: &Node<'_, '_>| child.is_element() && !has_prefix(*child);
    node.children().filter(own)
}

/// The elements of this name within an element, without those with a prefix.
pub(super) fn named<'a, 'input>(node: Node<'a, 'input>, name: &str) -> impl Iterator<Item = Node<'a, 'input>> {
    elements(node).filter(move |child| child.has_tag_name(name))
}

/// Returns true if the name of an element is written with a prefix: a default namespace has none.
fn has_prefix(element: Node<'_, '_>) -> bool {
    let text = element.document().input_text();
    let name = text.get(element.range().start..).unwrap_or_default();
    let is_end = |c: char| c.is_whitespace() || matches!(c, '/' | '>' | ':');
    name.find(is_end).is_some_and(|end| name[end..].starts_with(':'))
}

/// The element of this name within an element, of which there may be one.
pub(super) fn child<'a, 'input>(node: Node<'a, 'input>, name: &str) -> Read<Option<Node<'a, 'input>>> {
    let mut found = named(node, name);
    let first = found.next();
    if found.next().is_some() {
        return Err(format!("it has several {name} elements"));
    }
    Ok(first)
}

pub(super) fn required<'a, 'input>(node: Node<'a, 'input>, name: &str) -> Read<Node<'a, 'input>> {
    child(node, name)?.ok_or(format!("it has no {name} element"))
}

/// Reads a number from an attribute.
pub(super) fn number(node: Node<'_, '_>, attribute: &str) -> Read<f64> {
    numbers(node, attribute).map(|[number]| number)
}

/// Reads exactly `COUNT` numbers from an attribute that may be missing.
pub(super) fn optional<const COUNT: usize>(node: Node<'_, '_>, attribute: &str) -> Read<Option<[f64; COUNT]>> {
    let given = node.has_attribute(attribute);
    given.then(|| numbers(node, attribute)).transpose()
}

/// Reads exactly `COUNT` numbers from an attribute.
pub(super) fn numbers<const COUNT: usize>(node: Node<'_, '_>, attribute: &str) -> Read<[f64; COUNT]> {
    let element = node.tag_name().name();
    let text = (node.attribute(attribute)).ok_or(format!("its {element} has no {attribute}"))?;
    number_list(node, attribute).ok().and_then(|words| words.try_into().ok()).ok_or_else(|| {
        let wanted = match COUNT {
            1 => "a number".to_owned(),
            count => format!("{count} numbers"),
        };
        format!("{attribute} of its {element} is '{text}', not {wanted}")
    })
}

/// Reads any number of numbers from an attribute.
pub(super) fn number_list(node: Node<'_, '_>, attribute: &str) -> Read<Vec<f64>> {
    let element = node.tag_name().name();
    let text = (node.attribute(attribute)).ok_or(format!("its {element} has no {attribute}"))?;
    let words: Option<Vec<f64>> = text.split_whitespace().map(|w| w.parse().ok()).collect();
    words.ok_or_else(|| format!("{attribute} of its {element} is '{text}', not numbers"))
}
