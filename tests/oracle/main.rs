//! wip
#[test]
fn x() {}
