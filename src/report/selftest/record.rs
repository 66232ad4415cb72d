//! What a device left, as a file.

use serde::{Deserialize, Serialize};

use super::FileDigest;
use crate::{Error, Result};

/// The cases of one device.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Name of the device, driver, and the program's commit.
    pub made_by: String,
    /// Every case.
    pub cases: Vec<Case>,
}

/// One frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Case {
    /// In a few words.
    pub name: String,
    /// Its options on the command line.
    pub options: String,
    /// What its passes left, in the order of the frame.
    pub files: Vec<FileDigest>,
}

impl Record {
    /// The one that is part of the program.
    ///
    /// # Errors
    /// [`Error::Failure`] when it is none.
    pub fn of_program() -> Result<Self> {
        serde_json::from_str(include_str!("../../../assets/selftest.json"))
            .map_err(|error| Error::Failure(format!("assets/selftest.json is no record: {error}")))
    }

    /// As JSON, what each pass left on a line.
    ///
    /// # Errors
    /// [`Error::Failure`] when a number cannot be expressed.
    pub fn to_json(&self) -> Result<Vec<u8>> {
        let mut cases = Vec::new();
        for case in &self.cases {
            let files = case.files.iter().map(one_line).collect::<Result<Vec<_>>>()?.join(",\n");
            let (name, options) = (one_line(&case.name)?, one_line(&case.options)?);
            cases.push(format!("{{\"name\":{name},\"options\":{options},\"files\":[\n{files}\n]}}"));
        }
        let (made_by, cases) = (one_line(&self.made_by)?, cases.join(",\n"));
        Ok(format!("{{\"made_by\":{made_by},\"cases\":[\n{cases}\n]}}\n").into_bytes())
    }
}

fn one_line(value: &impl Serialize) -> Result<String> {
    serde_json::to_string(value).map_err(|error| Error::Failure(format!("cannot express the record as JSON: {error}")))
}

#[cfg(test)]
mod tests {
    use super::super::Digest;
    use super::*;

    #[test]
    fn a_record_is_read_as_it_was_written() {
        let digest = Digest { name: "x".to_owned(), count: 3, not_finite: 1, mean: 0.1, rms: 0.3 };
        let file =
            FileDigest { pass: "a/b".to_owned(), resource: "c".to_owned(), columns: vec![digest.clone(), digest] };
        let case = Case { name: "lgh".to_owned(), options: "--vpls 1".to_owned(), files: vec![file.clone(), file] };
        let record = Record { made_by: "a \"device\"".to_owned(), cases: vec![case.clone(), case] };
        let read: Record = serde_json::from_slice(&record.to_json().unwrap()).unwrap();
        assert_eq!(read, record);
    }

    #[test]
    fn the_program_has_one() {
        let record = Record::of_program().unwrap();
        assert!(record.cases.len() > 5 && record.cases.iter().all(|case| case.files.len() > 5));
    }
}
