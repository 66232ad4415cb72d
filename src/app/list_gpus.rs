//! `--list-gpus`: the devices and what they can do.

use crate::{Error, Result};

/// Prints every device, with each optional feature found or missing.
///
/// # Errors
/// [`Error::NoDevice`] without a Vulkan loader or driver.
pub fn list() -> Result<()> {
    Err(Error::Failure("this version cannot list devices yet".to_owned()))
}
