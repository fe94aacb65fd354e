//! Readers where serde's derived ones are not good enough: those accept lists for objects, and lose the location of an
//! error in values that may be of several types.
//!
//! - [`object!`]: objects, and names as short forms;
//! - [`Whole`]: whole numbers, with or without a decimal point;
//! - [`Kept`]: objects whose `kind` determines the other fields.

use std::fmt;
use std::marker::PhantomData;

use serde::Serialize;
use serde::de::value::{
    CowStrDeserializer, F64Deserializer, I64Deserializer, MapAccessDeserializer, U64Deserializer,
};
use serde::de::{
    Deserialize, DeserializeSeed, Deserializer, Error, MapAccess, SeqAccess, Unexpected, Visitor,
};
use serde_json::value::RawValue;

/// Encloses a JSON pointer in the text of an error, see [`below`].
pub(crate) const MARK: char = '\u{1}';

/// An error at a location below the value that is read, which no deserializer has seen.
pub(crate) fn below<E: Error>(pointer: &str, error: impl fmt::Display) -> E {
    E::custom(format_args!("{MARK}{pointer}{MARK}{error}"))
}

/// A JSON pointer (RFC 6901) to a location of serde_path_to_error.
pub(crate) fn pointer(path: &serde_path_to_error::Path) -> String {
    use serde_path_to_error::Segment;
    let step = |segment: &Segment| match segment {
        Segment::Seq { index } => format!("/{index}"),
        Segment::Map { key } => step(key),
        Segment::Enum { .. } | Segment::Unknown => String::new(),
    };
    path.iter().map(step).collect()
}

/// The step of a JSON pointer to a field.
pub(super) fn step(name: &str) -> String {
    format!("/{}", name.replace('~', "~0").replace('/', "~1"))
}

/// A type that is read from objects, and maybe from names as short forms.
pub(crate) trait Object<'de>: Sized {
    /// The expected form, for errors.
    const EXPECTED: &'static str;

    /// Reads it from the fields of an object.
    fn of_fields<D: Deserializer<'de>>(fields: D) -> Result<Self, D::Error>;

    /// Reads it from a name.
    fn of_name<E: Error>(name: &str) -> Result<Self, E> {
        Err(E::invalid_type(Unexpected::Str(name), &Self::EXPECTED))
    }

    /// The value for null, and for one of two directions that is left out.
    fn of_nothing<E: Error>() -> Result<Self, E> {
        Err(E::invalid_type(Unexpected::Unit, &Self::EXPECTED))
    }
}

/// Reads an object.
pub(crate) fn read_object<'de, T: Object<'de>, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<T, D::Error> {
    struct ObjectVisitor<T>(PhantomData<T>);

    impl<'de, T: Object<'de>> Visitor<'de> for ObjectVisitor<T> {
        type Value = T;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str(T::EXPECTED)
        }

        fn visit_unit<E: Error>(self) -> Result<T, E> {
            T::of_nothing()
        }

        fn visit_str<E: Error>(self, name: &str) -> Result<T, E> {
            T::of_name(name)
        }

        fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<T, A::Error> {
            T::of_fields(MapAccessDeserializer::new(map))
        }
    }

    deserializer.deserialize_any(ObjectVisitor(PhantomData))
}

/// Reads types from objects alone, and writes them, by what serde derives with `remote = "Self"`; with
/// `kind` they are also read from the value of this field, as an object with nothing else.
macro_rules! object {
    ($type:ty, $expected:literal $(, $kind:literal)?) => {
        impl<'de> $crate::model::serde_helpers::Object<'de> for $type {
            const EXPECTED: &'static str = $expected;

            fn of_fields<D: serde::Deserializer<'de>>(fields: D) -> Result<Self, D::Error> {
                <$type>::deserialize(fields)
            }

            $(fn of_name<E: serde::de::Error>(name: &str) -> Result<Self, E> {
                let fields = std::iter::once(($kind, name));
                <$type>::deserialize(serde::de::value::MapDeserializer::new(fields))
            })?
        }

        impl<'de> serde::Deserialize<'de> for $type {
            fn deserialize<D: serde::Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
                $crate::model::serde_helpers::read_object(d)
            }
        }

        impl serde::Serialize for $type {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                <$type>::serialize(self, serializer)
            }
        }
    };
}
pub(crate) use object;

/// A whole number, zero or greater: 3.0 and 3e0 are 3, as in JSON schemas.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub(crate) struct Whole(pub usize);

impl Whole {
    /// The expected form, for errors.
    pub(crate) const EXPECTED: &'static str = "a whole number, zero or greater";

    /// The whole number. One that is too large for this machine is too large for any limit.
    pub(crate) fn of<E: Error>(x: f64, expected: &dyn serde::de::Expected) -> Result<usize, E> {
        /// Up to here every whole number is exact.
        const EXACT: f64 = 9_007_199_254_740_992.0;
        match (0.0..=EXACT).contains(&x) && x.fract() == 0.0 {
            true => Ok(x as usize),
            false => Err(E::invalid_type(Unexpected::Float(x), expected)),
        }
    }
}

impl<'de> Deserialize<'de> for Whole {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct WholeVisitor;

        impl Visitor<'_> for WholeVisitor {
            type Value = Whole;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(Whole::EXPECTED)
            }

            fn visit_u64<E: Error>(self, n: u64) -> Result<Whole, E> {
                Ok(Whole(usize::try_from(n).unwrap_or(usize::MAX)))
            }

            fn visit_f64<E: Error>(self, x: f64) -> Result<Whole, E> {
                Whole::of(x, &self).map(Whole)
            }
        }

        deserializer.deserialize_any(WholeVisitor)
    }
}

/// Reads a field that is a whole number, if it is there.
pub(crate) fn whole<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<usize>, D::Error> {
    let whole = Option::<Whole>::deserialize(deserializer)?;
    Ok(whole.map(|Whole(n)| n))
}

/// Reads a field that may be left out, but not null.
pub(crate) fn some<'de, T: Deserialize<'de>, D: Deserializer<'de>>(
    d: D,
) -> Result<Option<T>, D::Error> {
    T::deserialize(d).map(Some)
}

/// An object of which the first name has been read.
pub(super) struct Peeked<A> {
    pub(super) name: Option<String>,
    pub(super) map: A,
}

impl<'de, A: MapAccess<'de>> MapAccess<'de> for Peeked<A> {
    type Error = A::Error;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, A::Error> {
        match self.name.take() {
            None => self.map.next_key_seed(seed),
            Some(name) => name_with(seed, name).map(Some),
        }
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, A::Error> {
        self.map.next_value_seed(seed)
    }
}

/// Reads a name that was kept.
fn name_with<'de, K: DeserializeSeed<'de>, E: Error>(seed: K, name: String) -> Result<K::Value, E> {
    let pointer = step(&name);
    let name = CowStrDeserializer::<E>::new(name.into());
    seed.deserialize(name)
        .map_err(|error| below(&pointer, error))
}

/// The fields of an object whose `kind` has been read: those before it are kept as they are written.
pub(crate) struct Kept<'de, A> {
    before: std::vec::IntoIter<(String, &'de RawValue)>,
    /// The field whose name was read last.
    value: Option<(String, &'de RawValue)>,
    map: A,
}

/// The most fields before the `kind` of an object; no valid object has more.
const MOST_BEFORE: usize = 100;

impl<'de, A: MapAccess<'de>> Kept<'de, A> {
    /// Reads the kind, wherever it stands.
    pub(crate) fn read<T: Deserialize<'de>>(mut map: A) -> Result<(T, Self), A::Error> {
        let mut before = Vec::new();
        while let Some(name) = map.next_key::<String>()? {
            if name == "kind" {
                let kind = map.next_value()?;
                let (before, value) = (before.into_iter(), None);
                return Ok((kind, Self { before, value, map }));
            }
            if before.len() == MOST_BEFORE {
                let detail = format!("there are more than {MOST_BEFORE} fields before the kind");
                return Err(below(&step(&name), detail));
            }
            before.push((name, map.next_value()?));
        }
        Err(A::Error::missing_field("kind"))
    }
}

impl<'de, A: MapAccess<'de>> MapAccess<'de> for Kept<'de, A> {
    type Error = A::Error;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, A::Error> {
        self.value = self.before.next();
        match &self.value {
            None => self.map.next_key_seed(seed),
            Some((name, _)) => name_with(seed, name.clone()).map(Some),
        }
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, A::Error> {
        let Some((name, value)) = self.value.take() else {
            return self.map.next_value_seed(seed);
        };
        let mut track = serde_path_to_error::Track::new();
        let mut value = serde_json::Deserializer::from_str(value.get());
        let value = serde_path_to_error::Deserializer::new(&mut value, &mut track);
        let read = seed.deserialize(value);
        read.map_err(|error| below(&(step(&name) + &pointer(&track.path())), error))
    }
}

/// A type for a number, or for a word that stands for none.
macro_rules! number_or_word {
    ($(#[$about:meta])* $type:ident($number:ty), $word:literal, $expected:literal) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub(crate) struct $type(pub(crate) Option<$number>);

        impl<'de> serde::Deserialize<'de> for $type {
            fn deserialize<D: serde::Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
                $crate::model::serde_helpers::read_number_or_word(d, $word, $expected).map(Self)
            }
        }

        impl serde::Serialize for $type {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                match self.0 {
                    Some(number) => number.serialize(serializer),
                    None => serializer.serialize_str($word),
                }
            }
        }
    };
}
pub(crate) use number_or_word;

/// Reads a number, or a word that stands for none.
pub(crate) fn read_number_or_word<'de, T: Deserialize<'de>, D: Deserializer<'de>>(
    deserializer: D,
    word: &'static str,
    expected: &'static str,
) -> Result<Option<T>, D::Error> {
    struct NumberVisitor<T>(&'static str, &'static str, PhantomData<T>);

    impl<'de, T: Deserialize<'de>> Visitor<'de> for NumberVisitor<T> {
        type Value = Option<T>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str(self.1)
        }

        fn visit_u64<E: Error>(self, n: u64) -> Result<Option<T>, E> {
            let number = T::deserialize(U64Deserializer::<E>::new(n)).map(Some);
            number.map_err(|_| E::invalid_type(Unexpected::Unsigned(n), &self))
        }

        fn visit_i64<E: Error>(self, n: i64) -> Result<Option<T>, E> {
            let number = T::deserialize(I64Deserializer::<E>::new(n)).map(Some);
            number.map_err(|_| E::invalid_type(Unexpected::Signed(n), &self))
        }

        fn visit_f64<E: Error>(self, x: f64) -> Result<Option<T>, E> {
            let number = T::deserialize(F64Deserializer::<E>::new(x)).map(Some);
            number.map_err(|_| E::invalid_type(Unexpected::Float(x), &self))
        }

        fn visit_str<E: Error>(self, text: &str) -> Result<Option<T>, E> {
            match text == self.0 {
                true => Ok(None),
                false => Err(E::invalid_type(Unexpected::Str(text), &self)),
            }
        }
    }

    deserializer.deserialize_any(NumberVisitor(word, expected, PhantomData))
}

/// A list of at most `MAX` elements, which no valid request exceeds.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(transparent)]
pub(crate) struct AtMost<T, const MAX: usize>(pub Vec<T>);

impl<'de, T: Deserialize<'de>, const MAX: usize> Deserialize<'de> for AtMost<T, MAX> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct ListVisitor<T, const MAX: usize>(PhantomData<T>);

        impl<'de, T: Deserialize<'de>, const MAX: usize> Visitor<'de> for ListVisitor<T, MAX> {
            type Value = AtMost<T, MAX>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a list")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Self::Value, A::Error> {
                let mut elements = Vec::new();
                while let Some(element) = list.next_element()? {
                    if elements.len() == MAX {
                        let detail = format!("at most {MAX} of them can be given here");
                        return Err(below(&format!("/{MAX}"), detail));
                    }
                    elements.push(element);
                }
                Ok(AtMost(elements))
            }
        }

        deserializer.deserialize_seq(ListVisitor(PhantomData))
    }
}
