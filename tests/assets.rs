//! The built-in scene is what its generator makes.

use std::process::Command;

#[test]
fn the_courtyard_is_what_its_generator_makes() {
    let root = env!("CARGO_MANIFEST_DIR");
    let check = Command::new("python3").arg(format!("{root}/tools/build_courtyard.py")).arg("--check").output();
    let Ok(output) = check else {
        println!("skipped: python3 is not installed");
        return;
    };
    let text = String::from_utf8_lossy(&output.stderr).into_owned() + &String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "tools/build_courtyard.py --check: {text}");
}
