//! A deserializer around that of the JSON text, which gives the types of the `gltf` crate what they expect where the
//! specification of glTF expects less.
//!
//! It works while the text is parsed, on whatever field is asked for, so that no field needs to be listed:
//!
//! - `extras`, which may be of any type, are skipped.
//! - A number without a fraction is an integer, however it is written: 12, 12.0 or 1.2e1.
//! - A number where a text is wanted is its text.
//! - What is optional by the specification and not by the crate is put in: [`MISSING`].
//! - An index beyond 32 bits is an error, and not another index.

use std::fmt;

use serde::de::value::SeqDeserializer;
use serde::de::{DeserializeSeed, Deserializer, Error, IgnoredAny, IntoDeserializer, MapAccess, SeqAccess, Visitor};

/// The index that stands for none where the crate insists on one: the node of an animation channel that an extension
/// gives another target.
pub(super) const NO_INDEX: u32 = u32::MAX;

/// A field that the crate insists on.
#[derive(Clone, Copy)]
struct Field {
    name: &'static str,
    value: Stand,
}

/// What stands for a field that is not there.
#[derive(Clone, Copy)]
enum Stand {
    EmptyList,
    NoIndex,
}

/// By the name of the crate's struct.
const MISSING: [(&str, &[Field]); 3] = [
    ("Scene", &[Field { name: "nodes", value: Stand::EmptyList }]),
    ("Target", &[Field { name: "node", value: Stand::NoIndex }]),
    // Two structs of this name: the list of the file, and the light of a node.
    (
        "KhrLightsPunctual",
        &[Field { name: "lights", value: Stand::EmptyList }, Field { name: "light", value: Stand::NoIndex }],
    ),
];

/// What kind of value is asked for.
#[derive(Clone, Copy)]
enum Wanted {
    Any,
    /// At most 32 bits.
    Integer,
    /// Up to 64 bits.
    Size,
    Text,
}

/// The deserializer around `D`.
pub(super) struct Lenient<D> {
    inner: D,
    is_size: bool,
}

impl<D> Lenient<D> {
    pub fn new(inner: D) -> Self {
        Self { inner, is_size: false }
    }
}

impl<'de, D: Deserializer<'de>> Lenient<D> {
    fn any<V: Visitor<'de>>(self, wanted: Wanted, visitor: V) -> Result<V::Value, D::Error> {
        self.inner.deserialize_any(Relay { visitor, wanted, missing: &[] })
    }

    fn integer<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, D::Error> {
        let wanted = if self.is_size { Wanted::Size } else { Wanted::Integer };
        self.any(wanted, visitor)
    }
}

/// Methods that hand the visitor on to one of the two above.
macro_rules! relayed {
    ($($method:ident: $how:ident($($wanted:expr)?);)*) => {
        $(fn $method<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, D::Error> {
            self.$how($($wanted,)? visitor)
        })*
    };
}

impl<'de, D: Deserializer<'de>> Deserializer<'de> for Lenient<D> {
    type Error = D::Error;

    relayed! {
        deserialize_any: any(Wanted::Any);
        deserialize_bool: any(Wanted::Any);
        deserialize_f32: any(Wanted::Any);
        deserialize_f64: any(Wanted::Any);
        deserialize_bytes: any(Wanted::Any);
        deserialize_byte_buf: any(Wanted::Any);
        deserialize_unit: any(Wanted::Any);
        deserialize_seq: any(Wanted::Any);
        deserialize_map: any(Wanted::Any);
        deserialize_char: any(Wanted::Text);
        deserialize_str: any(Wanted::Text);
        deserialize_string: any(Wanted::Text);
        deserialize_identifier: any(Wanted::Text);
        deserialize_i8: integer();
        deserialize_i16: integer();
        deserialize_i32: integer();
        deserialize_i64: integer();
        deserialize_u8: integer();
        deserialize_u16: integer();
        deserialize_u32: integer();
        deserialize_u64: integer();
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, D::Error> {
        self.inner.deserialize_option(Relay { visitor, wanted: Wanted::Any, missing: &[] })
    }

    fn deserialize_ignored_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, D::Error> {
        self.inner.deserialize_ignored_any(visitor)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, name: &'static str, visitor: V) -> Result<V::Value, D::Error> {
        if name.starts_with("$serde_json") {
            // Text that is kept as it is: between the crate and the parser.
            return self.inner.deserialize_newtype_struct(name, visitor);
        }
        let wanted = if name == "USize64" { Wanted::Size } else { Wanted::Any };
        self.inner.deserialize_newtype_struct(name, Relay { visitor, wanted, missing: &[] })
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        _fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, D::Error> {
        let missing = MISSING.iter().find(|(of, _)| *of == name).map_or(&[][..], |(_, fields)| fields);
        self.inner.deserialize_any(Relay { visitor, wanted: Wanted::Any, missing })
    }

    fn deserialize_unit_struct<V: Visitor<'de>>(self, _: &'static str, visitor: V) -> Result<V::Value, D::Error> {
        self.any(Wanted::Any, visitor)
    }

    fn deserialize_tuple<V: Visitor<'de>>(self, _: usize, visitor: V) -> Result<V::Value, D::Error> {
        self.any(Wanted::Any, visitor)
    }

    fn deserialize_tuple_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: usize,
        visitor: V,
    ) -> Result<V::Value, D::Error> {
        self.any(Wanted::Any, visitor)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        name: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, D::Error> {
        self.inner.deserialize_enum(name, variants, visitor)
    }
}

/// Hands what the parser finds on to `visitor`, changed where the visitor would refuse it.
struct Relay<V> {
    visitor: V,
    wanted: Wanted,
    missing: &'static [Field],
}

impl<V> Relay<V> {
    fn integer<'de, E: Error>(self, value: u64) -> Result<V::Value, E>
    where
        V: Visitor<'de>,
    {
        match self.wanted {
            Wanted::Text => self.visitor.visit_string(value.to_string()),
            Wanted::Integer if value > u64::from(u32::MAX) => {
                Err(E::custom(format_args!("the integer {value} is too large")))
            }
            _ => self.visitor.visit_u64(value),
        }
    }
}

impl<'de, V: Visitor<'de>> Visitor<'de> for Relay<V> {
    type Value = V::Value;

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        self.visitor.expecting(formatter)
    }

    fn visit_bool<E: Error>(self, value: bool) -> Result<V::Value, E> {
        self.visitor.visit_bool(value)
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<V::Value, E> {
        match (u64::try_from(value), self.wanted) {
            (Ok(value), _) => self.integer(value),
            (_, Wanted::Text) => self.visitor.visit_string(value.to_string()),
            _ => self.visitor.visit_i64(value),
        }
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<V::Value, E> {
        self.integer(value)
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<V::Value, E> {
        match self.wanted {
            // Beyond 2^53 the number that was written is not known.
            Wanted::Integer | Wanted::Size
                if value.fract() == 0.0 && (0.0..=9.007_199_254_740_992e15).contains(&value) =>
            {
                self.integer(value as u64)
            }
            Wanted::Text => self.visitor.visit_string(format!("{value:?}")),
            _ => self.visitor.visit_f64(value),
        }
    }

    fn visit_str<E: Error>(self, value: &str) -> Result<V::Value, E> {
        self.visitor.visit_str(value)
    }

    fn visit_borrowed_str<E: Error>(self, value: &'de str) -> Result<V::Value, E> {
        self.visitor.visit_borrowed_str(value)
    }

    fn visit_string<E: Error>(self, value: String) -> Result<V::Value, E> {
        self.visitor.visit_string(value)
    }

    fn visit_unit<E: Error>(self) -> Result<V::Value, E> {
        self.visitor.visit_unit()
    }

    fn visit_none<E: Error>(self) -> Result<V::Value, E> {
        self.visitor.visit_none()
    }

    fn visit_some<D: Deserializer<'de>>(self, inner: D) -> Result<V::Value, D::Error> {
        self.visitor.visit_some(Lenient::new(inner))
    }

    fn visit_newtype_struct<D: Deserializer<'de>>(self, inner: D) -> Result<V::Value, D::Error> {
        self.visitor.visit_newtype_struct(Lenient { inner, is_size: matches!(self.wanted, Wanted::Size) })
    }

    fn visit_seq<A: SeqAccess<'de>>(self, inner: A) -> Result<V::Value, A::Error> {
        self.visitor.visit_seq(List(inner))
    }

    fn visit_map<A: MapAccess<'de>>(self, inner: A) -> Result<V::Value, A::Error> {
        self.visitor.visit_map(Object { inner, missing: self.missing, seen: 0, stand: None })
    }
}

/// A value that is asked for through [`Lenient`].
struct Seed<S>(S);

impl<'de, S: DeserializeSeed<'de>> DeserializeSeed<'de> for Seed<S> {
    type Value = S::Value;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<S::Value, D::Error> {
        self.0.deserialize(Lenient::new(deserializer))
    }
}

struct List<A>(A);

impl<'de, A: SeqAccess<'de>> SeqAccess<'de> for List<A> {
    type Error = A::Error;

    fn next_element_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>, A::Error> {
        self.0.next_element_seed(Seed(seed))
    }

    fn size_hint(&self) -> Option<usize> {
        self.0.size_hint()
    }
}

/// An object without its `extras` and with what is missing.
struct Object<A> {
    inner: A,
    missing: &'static [Field],
    /// Bit n for the field n of `missing`.
    seen: u32,
    /// The value of the key that was put in.
    stand: Option<Stand>,
}

impl<'de, A: MapAccess<'de>> MapAccess<'de> for Object<A> {
    type Error = A::Error;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, A::Error> {
        let mut seed = Some(seed);
        while let Some(key) =
            self.inner.next_key_seed(Key { seed: &mut seed, missing: self.missing, seen: &mut self.seen })?
        {
            match key {
                Some(key) => return Ok(Some(key)),
                None => drop(self.inner.next_value::<IgnoredAny>()?),
            }
        }
        let absent = (0..self.missing.len()).find(|i| self.seen >> i & 1 == 0);
        let (Some(seed), Some(i)) = (seed, absent) else { return Ok(None) };
        self.seen |= 1 << i;
        self.stand = Some(self.missing[i].value);
        seed.deserialize(self.missing[i].name.into_deserializer()).map(Some)
    }

    fn next_value_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<S::Value, A::Error> {
        match self.stand.take() {
            None => self.inner.next_value_seed(Seed(seed)),
            Some(Stand::EmptyList) => seed.deserialize(SeqDeserializer::new(std::iter::empty::<u32>())),
            Some(Stand::NoIndex) => seed.deserialize(NO_INDEX.into_deserializer()),
        }
    }
}

/// A key, or `None` for `extras`, which leaves the seed where it was.
struct Key<'a, K> {
    seed: &'a mut Option<K>,
    missing: &'static [Field],
    seen: &'a mut u32,
}

impl<'de, K: DeserializeSeed<'de>> DeserializeSeed<'de> for Key<'_, K> {
    type Value = Option<K::Value>;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Self::Value, D::Error> {
        deserializer.deserialize_str(self)
    }
}

impl<'de, K: DeserializeSeed<'de>> Visitor<'de> for Key<'_, K> {
    type Value = Option<K::Value>;

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("a key")
    }

    fn visit_str<E: Error>(self, name: &str) -> Result<Self::Value, E> {
        if name == "extras" {
            return Ok(None);
        }
        if let Some(i) = self.missing.iter().position(|field| field.name == name) {
            *self.seen |= 1 << i;
        }
        self.seed.take().map(|seed| seed.deserialize(name.into_deserializer())).transpose()
    }
}
