//! Reasons why a figure of a motion may miss its bar although nothing is wrong.

pub mod beginning;
pub mod dependence;
pub mod large_numbers;
pub mod rest;
