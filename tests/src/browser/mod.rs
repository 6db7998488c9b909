//! A real browser: headless Chromium, driven through ChromeDriver over the WebDriver protocol (W3C, 2018).
//!
//! `cargo xtask test` builds the site, serves it, and names its address in [`SITE_VARIABLE`]; to run the browser tests
//! alone, leave `cargo xtask serve` running and set the variable to the address that it prints.

mod driver;
mod hands;
mod http;
mod picture;
mod session;

pub use driver::Driver;
pub use hands::{CONTROL, ENTER, ESCAPE};
pub use picture::Picture;
pub use session::{Browser, SITE_VARIABLE, site};
