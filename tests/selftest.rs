//! `gridlight selftest` on the device of the tests.

mod support;

use support::succeed;

#[test]
fn this_device_is_as_the_record_has_it() {
    let said = succeed(&["selftest", "--quiet", "--validation"]).stdout;
    let fine = said.lines().filter(|line| line.trim_end_matches('|').trim_end().ends_with("| ok")).count();
    assert_eq!(fine, 10, "{said}");
}
