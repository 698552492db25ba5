"""Places in Rust source by the item that they are in and a snippet that is in this item once."""

import functools
import re

# Comments, strings and characters, whose brackets and keywords are none. A lifetime has no closing quote.
OPAQUE = re.compile(
    r"""//[^\n]*|/\*|\b(?:b|c)?r(?P<hashes>\#*)".*?"(?P=hashes)|"(?:\\.|[^"\\])*"|'(?:\\u\{\w+\}|\\.[^']*|[^'\\])'""",
    re.DOTALL,
)
# Keywords stand where an item may begin, which those in `&'static str` and `<const N: usize>` do not.
ITEM = re.compile(
    r"(?:(?<=[{};\])])|^|\b(?:pub|const|unsafe|async|extern))\s*"
    r"(?:(?P<kind>fn|mod|trait|struct|enum|union|type|static|const|macro_rules!)\s+(?!fn\b)(?:mut\s+)?(?P<name>\w+)"
    r"|(?P<impl>impl)\b)|(?P<macro>^\w+!)",
    re.MULTILINE,
)
BRACKET = re.compile(r"[(\[{}\]);]")
COMMENT_END = re.compile(r"/\*|\*/")
OPEN, CLOSE = "([{", ")]}"


def code_of(text):
    """The text with spaces for everything in comments, strings and characters; all else is at its place."""
    parts, at = [], 0
    while found := OPAQUE.search(text, at):
        end, depth = found.end(), int(found[0] == "/*")
        # Such comments may contain one another.
        while depth and (mark := COMMENT_END.search(text, end)):
            depth += 1 if mark[0] == "/*" else -1
            end = mark.end()
        parts += [text[at : found.start()], re.sub(r"[^\n]", " ", text[found.start() : end])]
        at = end
    return "".join(parts) + text[at:]


def extent(code, start, has_block):
    """Where the header of an item ends and where the item does: behind its block, or else its semicolon."""
    depth, header = 0, None
    for mark in BRACKET.finditer(code, start):
        if mark[0] in OPEN:
            if mark[0] == "{" and depth == 0 and has_block:
                header = mark.start()
            depth += 1
        elif mark[0] in CLOSE:
            depth -= 1
            if depth == 0 and header is not None:
                return header, mark.end()
        elif depth == 0:
            return mark.start(), mark.end()
    return len(code), len(code)


def bare(name):
    """A type or trait without references, modules and parameters: `Joint` for `&'a super::Joint<S>`."""
    while name != (shorter := re.sub(r"<[^<>]*>", "", name)):
        name = shorter
    name = re.sub(r"&\s*('\w+\s*)?(mut\s+)?|\bdyn\s+|\w+::", "", name)
    return name.strip()


def owner(header):
    """The type and the trait, if any, of an `impl` with this header."""
    header = re.sub(r"\s+", " ", header.replace("->", " ")).strip()
    if header.startswith("<"):
        depth = 0
        for at, character in enumerate(header):
            depth += (character == "<") - (character == ">")
            if depth == 0:
                break
        header = header[at + 1 :]
    trait, _, of = header.split(" where ")[0].rpartition(" for ")
    return bare(of), bare(trait)


@functools.cache
def items(text):
    """The items of a file: kind and path, as in `fn Joint::placement` and `impl Method for Bdf`, and their extent."""
    code, found, scopes, inside = code_of(text), [], [], 0
    for match in ITEM.finditer(code):
        # The header of an item has no items, and those that a macro makes are known to it alone.
        if match.start() < inside:
            continue
        kind, name, trait = match["kind"] or "impl", match["name"], ""
        header, end = extent(code, match.end(), kind not in ("const", "static", "type"))
        if match["macro"] or kind == "macro_rules!":
            found.append((match["macro"] or f"macro_rules! {name}", match.start(), end))
            inside = end
            continue
        inside = header
        while scopes and scopes[-1][1] <= match.start():
            scopes.pop()
        if match["impl"]:
            name, trait = owner(code[match.end() : header])
        path = "::".join([scope for scope, _ in scopes] + [name])
        found.append((f"{kind} {trait} for {path}" if trait else f"{kind} {path}", match.start(), end))
        if kind in ("impl", "fn", "mod", "trait"):
            scopes.append((name, end))
    return found


def pattern(snippet):
    """The pattern of a snippet by its words and signs: lines may be broken elsewhere, with commas before brackets."""
    tokens = re.findall(r"\w+|[^\w\s]", snippet)
    parts = []
    for i, token in enumerate(tokens):
        last, following = tokens[i - 1 : i], tokens[i + 1 : i + 2]
        if token == "," and following and following[0] in CLOSE:
            continue
        words = last and re.match(r"\w", last[0]) and re.match(r"\w", token)
        parts.append((r"\s+" if words else r"\s*" if i else "") + (r"(?:,\s*)?" if i and token in CLOSE else ""))
        parts.append(re.escape(token))
    starts, ends = (re.match(r"\w", tokens[i]) for i in (0, -1))
    return re.compile((r"(?<!\w)" if starts else "") + "".join(parts) + (r"(?!\w)" if ends else ""))


def places(text, item, snippet):
    """Where the snippet is in the items of this kind and path, or in all of the text without an item."""
    parts = [(0, len(text))] if item is None else [(start, end) for name, start, end in items(text) if name == item]
    if not parts:
        raise LookupError(f"has no {item}")
    return sorted({found.span() for start, end in parts for found in pattern(snippet).finditer(text, start, end)})
