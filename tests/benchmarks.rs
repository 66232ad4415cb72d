//! `tools/bench`: its own tests, and one small run of it with the built program.

use std::path::Path;
use std::process::{Command, Output};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// Runs Python in the root of the project; nothing where there is none.
fn python(arguments: &[&str]) -> Option<Output> {
    let mut found = Command::new("python3");
    found.args(arguments).current_dir(ROOT).env("PYTHONDONTWRITEBYTECODE", "1");
    let found = found.env("XDG_CACHE_HOME", concat!(env!("CARGO_TARGET_TMPDIR"), "/cache")).output();
    if found.is_err() {
        println!("skipped: python3 is not installed");
    }
    found.ok()
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).expect("text")
}

/// What is wrong with a run of `tools/bench tables`: an exit code, a message that is no progress, a file or a part of
/// it that is missing.
fn faults(code: Option<i32>, messages: &str, results: &Path) -> Vec<String> {
    let mut found = Vec::new();
    if code != Some(0) {
        found.push(format!("exit code {code:?}"));
    }
    for line in messages.lines() {
        let progress = line.contains(" ms") || line.starts_with("written to ");
        if !progress && !line.ends_with("apt-get install python3-matplotlib") {
            found.push(format!("said: {line}"));
        }
    }
    let folders = std::fs::read_dir(results).into_iter().flatten().flatten();
    let files: Vec<_> = folders.map(|folder| folder.path().join("tables.md")).filter(|file| file.exists()).collect();
    let [file] = files.as_slice() else {
        found.push(format!("{} files tables.md", files.len()));
        return found;
    };
    if !file.with_extension("json").exists() {
        found.push("no tables.json".to_owned());
    }
    let page = std::fs::read_to_string(file).unwrap_or_default();
    for part in ["# Table 1", "| Total |", "# Table 2", "# Table 3", "# Growth", "# Figure 5", "# Memory", "# Commands"]
    {
        if !page.contains(part) {
            found.push(format!("no {part}"));
        }
    }
    found
}

#[test]
fn statistics_tables_and_sentences() {
    let Some(output) = python(&["-m", "unittest", "discover", "-s", "tools/benchmarks/tests", "-t", "tools"]) else {
        return;
    };
    let said = text(&output.stderr);
    assert!(output.status.success(), "{said}");
    let count = said.lines().find_map(|line| line.strip_prefix("Ran ")?.split(' ').next()?.parse().ok());
    assert!(count.is_some_and(|count: u32| count >= 20), "too few tests ran: {said}");
}

#[test]
fn the_tables_come_out_of_the_built_program() {
    let results = Path::new(env!("CARGO_TARGET_TMPDIR")).join("benchmarks");
    let _ = std::fs::remove_dir_all(&results);
    let program =
        ["--program", env!("CARGO_BIN_EXE_gridlight"), "--results", results.to_str().expect("a name in Unicode")];
    let bench = |options: &[&str]| {
        python(&[&["tools/bench", "tables", "--quick", "--scene", "courtyard"], program.as_slice(), options].concat())
    };
    let Some(output) = bench(&[]) else {
        return;
    };
    assert_eq!(faults(output.status.code(), text(&output.stderr), &results), Vec::<String>::new());
    // What a fault looks like.
    let failed = bench(&["--gpu", "there is no such device"]).expect("Python is there");
    let found = faults(failed.status.code(), text(&failed.stderr), &results);
    assert!(found.iter().any(|fault| fault.starts_with("exit code")), "{found:?}");
    assert!(found.iter().any(|fault| fault.starts_with("said: error: ")), "{found:?}");
    std::fs::remove_dir_all(&results).expect("made above");
    let found = faults(Some(0), "", &results);
    assert_eq!(found, ["0 files tables.md"]);
}

/// What is wrong with the results of `tools/bench scale`: an input that did not become a picture, or too few of them.
fn faults_of_inputs(results: &Path) -> Vec<String> {
    let folders = std::fs::read_dir(results).into_iter().flatten().flatten();
    let file = folders.map(|folder| folder.path().join("scale.json")).find(|file| file.exists());
    let text = file.and_then(|file| std::fs::read_to_string(file).ok()).unwrap_or_default();
    let found: serde_json::Value = serde_json::from_str(&text).unwrap_or_default();
    let inputs = found["inputs"].as_array().cloned().unwrap_or_default();
    let mut faults: Vec<String> = inputs
        .iter()
        .filter(|input| input["result"] != "a picture")
        .map(|input| format!("{}: {}", input["case"], input["result"]))
        .collect();
    if inputs.len() < 11 {
        faults.push(format!("{} inputs", inputs.len()));
    }
    faults
}

#[test]
fn the_inputs_that_are_made_are_read() {
    let results = Path::new(env!("CARGO_TARGET_TMPDIR")).join("benchmarks-scale");
    let _ = std::fs::remove_dir_all(&results);
    assert_eq!(faults_of_inputs(&results), ["0 inputs"]);
    let program =
        ["--program", env!("CARGO_BIN_EXE_gridlight"), "--results", results.to_str().expect("a name in Unicode")];
    let Some(output) = python(&[&["tools/bench", "scale", "--quick"], program.as_slice()].concat()) else {
        return;
    };
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert_eq!(faults_of_inputs(&results), Vec::<String>::new());
}
