//! Changes of JSON that leave it JSON: other types, numbers at the edges, cut and repeated lists, keys given twice.

use serde_json::{Map, Value, json};

use super::random::Random;

/// Begins a string that is written without quotes, for numbers that `Value` cannot hold.
const BARE: char = '\u{1}';

/// A text of the JSON with a few changes.
pub fn changed(mut root: Value, random: &mut Random) -> String {
    for _ in 0..=random.below(3) {
        let other = nth(&root, random.below(count(&root))).clone();
        let mut place = random.below(count(&root));
        edit(&mut root, &mut place, &mut |value| *value = change(value.take(), &other, random));
    }
    let mut twice = if random.one_in(8) { random.below(objects(&root)) } else { usize::MAX };
    let mut text = String::new();
    write(&root, &mut text, &mut twice);
    text
}

fn children(value: &Value) -> Box<dyn Iterator<Item = &Value> + '_> {
    match value {
        Value::Array(list) => Box::new(list.iter()),
        Value::Object(map) => Box::new(map.values()),
        _ => Box::new(std::iter::empty()),
    }
}

fn count(value: &Value) -> usize {
    1 + children(value).map(count).sum::<usize>()
}

fn objects(value: &Value) -> usize {
    usize::from(value.is_object()) + children(value).map(objects).sum::<usize>()
}

/// The value with this number, the root being 0.
fn nth(value: &Value, mut number: usize) -> &Value {
    let mut found = value;
    'down: while number > 0 {
        number -= 1;
        for child in children(found) {
            let inside = count(child);
            if number < inside {
                found = child;
                continue 'down;
            }
            number -= inside;
        }
        return found;
    }
    found
}

/// Calls `change` for the value that `place` counts down to.
fn edit(value: &mut Value, place: &mut usize, change: &mut dyn FnMut(&mut Value)) {
    if *place == 0 {
        change(value);
        *place = usize::MAX;
        return;
    }
    *place -= 1;
    let children: Box<dyn Iterator<Item = &mut Value>> = match value {
        Value::Array(list) => Box::new(list.iter_mut()),
        Value::Object(map) => Box::new(map.values_mut()),
        _ => return,
    };
    for child in children {
        if *place == usize::MAX {
            return;
        }
        edit(child, place, change);
    }
}

fn change(value: Value, other: &Value, random: &mut Random) -> Value {
    match (random.below(5), value) {
        (0, _) => something(random),
        (1, _) => other.clone(),
        (2, value) if random.one_in(4) => {
            let deep = random.below(300);
            (0..deep).fold(value, |inner, _| json!([inner]))
        }
        (_, Value::Number(number)) => other_number(number.as_f64().unwrap_or(0.0), random),
        (_, Value::String(text)) => other_text(&text, random),
        (_, Value::Array(list)) => Value::Array(other_list(list, random)),
        (_, Value::Object(map)) => Value::Object(other_object(map, random)),
        (_, Value::Bool(is)) => Value::Bool(!is),
        (_, Value::Null) => something(random),
    }
}

fn bare(text: &str) -> Value {
    Value::String(format!("{BARE}{text}"))
}

/// A value of any type.
fn something(random: &mut Random) -> Value {
    match random.below(8) {
        0 => Value::Null,
        1 => Value::Bool(random.one_in(2)),
        2 => json!([]),
        3 => json!({}),
        4 => json!({"extensions": [0], "extras": null}),
        5 => Value::String(String::new()),
        6 => other_text("", random),
        _ => other_number(0.0, random),
    }
}

fn other_number(number: f64, random: &mut Random) -> Value {
    const EDGES: [&str; 18] = [
        "0",
        "-0.0",
        "1",
        "-1",
        "127",
        "255",
        "256",
        "65535",
        "2147483648",
        "4294967295",
        "4294967296",
        "18446744073709551615",
        "18446744073709551616",
        "-9223372036854775808",
        "1e38",
        "1e39",
        "1e999",
        "5126",
    ];
    match random.below(5) {
        0 => json!(number + 1.0),
        1 => json!(number - 1.0),
        2 => bare(&format!("{}", random.of_any_size(28))),
        3 => bare(&format!("{}", (number.abs() as u64).wrapping_mul(1 << random.below(40)))),
        _ => bare(random.word(&EDGES)),
    }
}

fn other_text(text: &str, random: &mut Random) -> Value {
    const TEXTS: [&str; 14] = [
        "SCALAR",
        "VEC3",
        "MAT4",
        "LINEAR",
        "CUBICSPLINE",
        "rotation",
        "weights",
        "BLEND",
        "a.bin",
        "../x",
        "data:,",
        "data:;base64,AAAA",
        "\n\u{1b}",
        "é\u{feff}",
    ];
    match random.below(4) {
        0 => Value::String(text.chars().take(random.below(1 + text.len())).collect()),
        1 => Value::String(text.repeat(1 + random.below(3))),
        2 if random.one_in(8) => Value::String("y".repeat(50_000)),
        _ => Value::String(random.word(&TEXTS).to_owned()),
    }
}

fn other_list(mut list: Vec<Value>, random: &mut Random) -> Vec<Value> {
    let at = random.below(list.len());
    match random.below(5) {
        0 => list.truncate(at),
        1 if !list.is_empty() => drop(list.remove(at)),
        2 if !list.is_empty() => {
            let copies = 1 + random.of_any_size(13);
            list.extend(std::iter::repeat_n(list[at].clone(), copies));
        }
        3 if !list.is_empty() => {
            let other = random.below(list.len());
            list.swap(at, other);
        }
        _ => list.push(something(random)),
    }
    list
}

fn other_object(mut map: Map<String, Value>, random: &mut Random) -> Map<String, Value> {
    let keys: Vec<String> = map.keys().cloned().collect();
    if keys.is_empty() || random.one_in(4) {
        map.insert(
            random.word(&["extensions", "extras", "name", "", "sparse", "mesh", "uri"]).to_owned(),
            something(random),
        );
        return map;
    }
    let value = map.remove(random.pick(&keys)).unwrap_or(Value::Null);
    if random.one_in(2) {
        map.insert(random.pick(&keys).clone(), value);
    }
    map
}

/// Writes JSON; the object that `twice` counts down to has its first key twice.
fn write(value: &Value, text: &mut String, twice: &mut usize) {
    match value {
        Value::String(content) if content.starts_with(BARE) => text.push_str(&content[1..]),
        Value::Array(list) => {
            text.push('[');
            for (i, item) in list.iter().enumerate() {
                text.push_str(if i > 0 { "," } else { "" });
                write(item, text, twice);
            }
            text.push(']');
        }
        Value::Object(map) => {
            let repeats = *twice == 0;
            *twice = twice.wrapping_sub(1);
            text.push('{');
            let first = map.iter().take(usize::from(repeats));
            for (i, (key, item)) in map.iter().chain(first).enumerate() {
                text.push_str(if i > 0 { "," } else { "" });
                text.push_str(&Value::String(key.clone()).to_string());
                text.push(':');
                write(item, text, twice);
            }
            text.push('}');
        }
        other => text.push_str(&other.to_string()),
    }
}
