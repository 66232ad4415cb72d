//! README and the results that it quotes.

use std::path::Path;

/// What a row of README's results claims: the numbers of one cell, and the row of a results file that has them.
#[derive(Debug)]
struct Claim {
    numbers: Vec<String>,
    /// First cell of the row in the file.
    row: String,
    file: String,
}

/// The rows under "## Results" that name a file of results as `[table: row](file)`.
fn claims(readme: &str) -> Vec<Claim> {
    let section = readme.split("\n## ").find(|section| section.starts_with("Results\n")).expect("a section of results");
    section.lines().filter_map(claim).collect()
}

fn claim(line: &str) -> Option<Claim> {
    let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
    let (label, rest) = cells.last()?.strip_prefix('[')?.split_once("](")?;
    let (_, row) = label.split_once(": ")?;
    let numbers = cells[1..cells.len() - 1].iter().flat_map(|cell| numbers(cell)).collect();
    Some(Claim { numbers, row: row.to_owned(), file: rest.trim_end_matches(')').to_owned() })
}

/// The numbers in a text, as they are written.
fn numbers(text: &str) -> Vec<String> {
    let parts = text.split(|c: char| !c.is_ascii_digit() && c != '.').map(|part| part.trim_matches('.'));
    parts.filter(|part| !part.is_empty()).map(str::to_owned).collect()
}

/// Claims whose file has no such row with all of their numbers.
fn contradicted<'a>(claims: &'a [Claim], read: &dyn Fn(&str) -> String) -> Vec<&'a Claim> {
    let holds = |claim: &Claim| {
        let start = format!("| {} |", claim.row);
        let text = read(&claim.file);
        let mut rows = text.lines().filter(|line| line.starts_with(&start));
        !claim.numbers.is_empty() && rows.any(|row| claim.numbers.iter().all(|number| numbers(row).contains(number)))
    };
    claims.iter().filter(|claim| !holds(claim)).collect()
}

fn file(path: &str) -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).unwrap_or_else(|e| panic!("{path}: {e}"))
}

#[test]
fn the_readme_quotes_current_results() {
    let claims = claims(&file("README.md"));
    assert!(claims.len() >= 6, "{claims:?}");
    let found = contradicted(&claims, &file);
    assert!(found.is_empty(), "README and results disagree, or name another row: {found:?}");
}

#[test]
fn a_changed_number_is_found() {
    let readme =
        "# a\n\n## Results\n\n| | here | paper | |\n| frame | 1532 ms | 30.2 ms | [Table 3: Total](a.md) |\n\n## b\n";
    let results = |total: &str| {
        format!("| Total | 695 (7) |\n| Total | {total} (1534) |  | 30.2 | 9 |\n| Totals | 1532 | 30.2 |\n")
    };
    let claims = claims(readme);
    assert_eq!(claims.len(), 1);
    assert!(contradicted(&claims, &|_| results("1532")).is_empty());
    assert_eq!(contradicted(&claims, &|_| results("1533")).len(), 1);
    assert_eq!(contradicted(&claims, &|_| results("11532")).len(), 1);
}

/// Links of README and of the pages to files of the repository.
#[test]
fn links_lead_somewhere() {
    let mut pages = vec!["README.md".to_owned()];
    for entry in std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs")).unwrap().flatten() {
        let name = entry.file_name().into_string().unwrap();
        pages.extend(name.ends_with(".md").then(|| format!("docs/{name}")));
    }
    let mut broken = Vec::new();
    for page in &pages {
        let (folder, text) = (Path::new(page).parent().unwrap(), file(page));
        for link in text.split("](").skip(1).filter_map(|rest| rest.split([')', '#']).next()) {
            let is_local = !link.is_empty() && !link.contains("://") && !link.contains(' ');
            if is_local && !Path::new(env!("CARGO_MANIFEST_DIR")).join(folder).join(link).exists() {
                broken.push(format!("{page}: {link}"));
            }
        }
    }
    assert!(pages.len() > 10 && broken.is_empty(), "{broken:?}");
}
