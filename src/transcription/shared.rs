//! Data that is borrowed for one search, or shared by searches that keep their memory.

use std::ops::Deref;
use std::sync::Arc;

/// A reference, or an owner beside others.
#[derive(Debug)]
pub enum Shared<'a, T> {
    /// A reference.
    Borrowed(&'a T),
    /// One of several owners.
    Owned(Arc<T>),
}

impl<T> Clone for Shared<'_, T> {
    fn clone(&self) -> Self {
        match self {
            Self::Borrowed(it) => Self::Borrowed(it),
            Self::Owned(it) => Self::Owned(it.clone()),
        }
    }
}

impl<T> Deref for Shared<'_, T> {
    type Target = T;

    fn deref(&self) -> &T {
        match self {
            Self::Borrowed(it) => it,
            Self::Owned(it) => it,
        }
    }
}

impl<'a, T> From<&'a T> for Shared<'a, T> {
    fn from(it: &'a T) -> Self {
        Self::Borrowed(it)
    }
}

impl<T> From<Arc<T>> for Shared<'_, T> {
    fn from(it: Arc<T>) -> Self {
        Self::Owned(it)
    }
}
