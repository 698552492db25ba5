//! The checker of certificates: its arithmetic, and its verdicts.

mod arithmetic;
mod conformance;
