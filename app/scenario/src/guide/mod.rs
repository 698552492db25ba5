//! A book in pages: from a first motion to all keys of a scenario. The library's own pages are [`aghf::guide`].

#[doc = include_str!("first_motion.md")]
#[doc = include_str!("pictures/first_motion.svg")]
pub mod first_motion {}

#[doc = include_str!("asking_for_more.md")]
#[doc = include_str!("pictures/obstacles.svg")]
pub mod asking_for_more {}

#[doc = include_str!("limits.md")]
#[doc = include_str!("pictures/limits.svg")]
pub mod limits {}

#[doc = include_str!("objectives.md")]
#[doc = include_str!("pictures/objectives.svg")]
pub mod objectives {}

#[doc = include_str!("goals.md")]
#[doc = include_str!("pictures/goals.svg")]
pub mod goals {}

#[doc = include_str!("standing.md")]
#[doc = include_str!("pictures/standing.svg")]
pub mod standing {}

#[doc = include_str!("variants.md")]
pub mod variants {}

#[doc = include_str!("moveit.md")]
pub mod moveit {}

#[doc = include_str!("certificates.md")]
#[doc = include_str!("pictures/certificates.svg")]
pub mod certificates {}
