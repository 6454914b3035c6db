//! JSON Schema of a file from the type that reads it, so that editors complete and check what they write.
//!
//! The type is asked by its own [`serde`] implementation: it is given a value for everything it asks for, and what it asked is the
//! schema. Which keys it cannot do without, and whether it takes others, is found by leaving each out and by giving it one more.

use std::cell::RefCell;
use std::fmt;

use serde::Deserialize;
use serde::de::value::BorrowedStrDeserializer;
use serde::de::{self, DeserializeSeed, EnumAccess, MapAccess, SeqAccess, VariantAccess, Visitor};
use serde_json::{Map, Value, json};

/// Schema (draft 2020-12) of the file that `T` is read from.
///
/// # Errors
/// [`Refused`] where `T` takes none of the values it is given, which a reader that checks values while it reads does.
pub fn schema_of<'de, T: Deserialize<'de>>(title: &str) -> Result<Value, Refused> {
    let shape = probe_shape::<T>(&Question::Nothing)?;
    let mut schema = describe::<T>(&shape, &mut Vec::new());
    if let Value::Object(fields) = &mut schema {
        fields.insert("$schema".to_owned(), json!("https://json-schema.org/draft/2020-12/schema"));
        fields.insert("title".to_owned(), json!(title));
    }
    Ok(schema)
}

/// A type refused what it was given.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refused(String);

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Refused {}

impl de::Error for Refused {
    fn custom<T: fmt::Display>(message: T) -> Self {
        Self(message.to_string())
    }
}

/// What a type asks for.
#[derive(Clone, Debug, Default)]
enum Shape {
    #[default]
    Any,
    Bool,
    Integer,
    Number,
    Text,
    Choice(&'static [&'static str]),
    List(Box<Shape>),
    Tuple(Vec<Shape>),
    /// Keys of the user's own.
    Table(Box<Shape>),
    Struct(Vec<(&'static str, Shape)>),
}

/// Place of a struct: the keys that lead to it; entries of lists and tables are `*`.
type Place = Vec<&'static str>;

/// What is found out by one reading.
enum Question {
    Nothing,
    /// Does it do without the last key of the place?
    Without(Place),
    /// Does the struct at the place take a key it does not know?
    With(Place),
    /// What has the variant of this index of the enum at the place? `None` is nothing but its name.
    Variant(Place, usize, RefCell<Option<Shape>>),
}

fn probe_shape<'de, T: Deserialize<'de>>(question: &Question) -> Result<Shape, Refused> {
    let mut shape = Shape::Any;
    T::deserialize(Asker { shape: &mut shape, place: Vec::new(), question })?;
    Ok(shape)
}

fn describe<'de, T: Deserialize<'de>>(shape: &Shape, place: &mut Place) -> Value {
    let mut entry = |shape: &Shape| {
        place.push("*");
        let described = describe::<T>(shape, place);
        place.pop();
        described
    };
    match shape {
        Shape::Any => json!({}),
        Shape::Bool => json!({ "type": "boolean" }),
        Shape::Integer => json!({ "type": "integer" }),
        Shape::Number => json!({ "type": "number" }),
        Shape::Text => json!({ "type": "string" }),
        Shape::Choice(names) => choice::<T>(names, place),
        Shape::List(inner) => json!({ "type": "array", "items": entry(inner) }),
        Shape::Tuple(parts) => {
            let described: Vec<Value> = parts.iter().map(entry).collect();
            json!({ "type": "array", "prefixItems": described, "minItems": parts.len(), "maxItems": parts.len() })
        }
        Shape::Table(inner) => json!({ "type": "object", "additionalProperties": entry(inner) }),
        Shape::Struct(fields) => {
            let (mut properties, mut required) = (Map::new(), Vec::new());
            for (name, shape) in fields {
                place.push(name);
                properties.insert((*name).to_owned(), describe::<T>(shape, place));
                if probe_shape::<T>(&Question::Without(place.clone())).is_err() {
                    required.push(*name);
                }
                place.pop();
            }
            let open = probe_shape::<T>(&Question::With(place.clone())).is_ok();
            let mut schema = json!({ "type": "object", "properties": properties });
            if let Value::Object(schema) = &mut schema {
                if !required.is_empty() {
                    schema.insert("required".to_owned(), json!(required));
                }
                if !open {
                    schema.insert("additionalProperties".to_owned(), json!(false));
                }
            }
            schema
        }
    }
}

/// An enum: names of variants that have nothing else, and an object of one key for each other.
fn choice<'de, T: Deserialize<'de>>(names: &'static [&'static str], place: &mut Place) -> Value {
    let (mut plain, mut others) = (Vec::new(), Vec::new());
    for (index, name) in names.iter().enumerate() {
        let question = Question::Variant(place.clone(), index, RefCell::new(None));
        // What it makes of the value does not matter, only what it asked for.
        let _ = probe_shape::<T>(&question);
        let Question::Variant(_, _, found) = question else { continue };
        match found.into_inner() {
            None => plain.push(*name),
            Some(shape) => {
                place.push(name);
                let mut properties = Map::new();
                properties.insert((*name).to_owned(), describe::<T>(&shape, place));
                place.pop();
                let object = json!({ "type": "object", "properties": properties, "required": [name] });
                others.push(object);
            }
        }
    }
    if others.is_empty() {
        return json!({ "enum": plain });
    }
    if !plain.is_empty() {
        others.insert(0, json!({ "enum": plain }));
    }
    json!({ "oneOf": others })
}

/// Gives a type what it asks for, and notes what that was.
struct Asker<'a> {
    shape: &'a mut Shape,
    place: Place,
    question: &'a Question,
}

/// Beginning of the names of the structs in which the TOML reader hands on where a value stood.
const SPANNED: &str = "$__serde_spanned";
/// Beginning of the names of other structs of the TOML reader.
const PRIVATE: &str = "$__";

macro_rules! plain {
    ($($method:ident => $shape:ident, $visit:ident($value:expr);)*) => {
        $(fn $method<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refused> {
            *self.shape = Shape::$shape;
            visitor.$visit($value)
        })*
    };
}

impl<'de> de::Deserializer<'de> for Asker<'_> {
    type Error = Refused;

    plain! {
        deserialize_any => Any, visit_str("");
        deserialize_bool => Bool, visit_bool(false);
        deserialize_i8 => Integer, visit_i8(1);
        deserialize_i16 => Integer, visit_i16(1);
        deserialize_i32 => Integer, visit_i32(1);
        deserialize_i64 => Integer, visit_i64(1);
        deserialize_u8 => Integer, visit_u8(1);
        deserialize_u16 => Integer, visit_u16(1);
        deserialize_u32 => Integer, visit_u32(1);
        deserialize_u64 => Integer, visit_u64(1);
        deserialize_f32 => Number, visit_f32(1.0);
        deserialize_f64 => Number, visit_f64(1.0);
        deserialize_char => Text, visit_char(' ');
        deserialize_str => Text, visit_str("");
        deserialize_string => Text, visit_str("");
        deserialize_bytes => Any, visit_bytes(&[]);
        deserialize_byte_buf => Any, visit_bytes(&[]);
        deserialize_identifier => Text, visit_str("");
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refused> {
        visitor.visit_some(self)
    }

    fn deserialize_unit<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refused> {
        visitor.visit_unit()
    }

    fn deserialize_ignored_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refused> {
        visitor.visit_unit()
    }

    fn deserialize_unit_struct<V: Visitor<'de>>(self, _: &'static str, visitor: V) -> Result<V::Value, Refused> {
        visitor.visit_unit()
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, _: &'static str, visitor: V) -> Result<V::Value, Refused> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_seq<V: Visitor<'de>>(mut self, visitor: V) -> Result<V::Value, Refused> {
        let mut inner = Shape::Any;
        self.place.push("*");
        let entries = Entries { left: 1, shapes: Vec::new(), place: &self.place, question: self.question };
        let (value, shapes) = entries.visit(visitor)?;
        if let Some(first) = shapes.into_iter().next() {
            inner = first;
        }
        *self.shape = Shape::List(Box::new(inner));
        Ok(value)
    }

    fn deserialize_tuple<V: Visitor<'de>>(mut self, count: usize, visitor: V) -> Result<V::Value, Refused> {
        self.place.push("*");
        let entries = Entries { left: count, shapes: Vec::new(), place: &self.place, question: self.question };
        let (value, shapes) = entries.visit(visitor)?;
        *self.shape = Shape::Tuple(shapes);
        Ok(value)
    }

    fn deserialize_tuple_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        count: usize,
        visitor: V,
    ) -> Result<V::Value, Refused> {
        self.deserialize_tuple(count, visitor)
    }

    fn deserialize_map<V: Visitor<'de>>(mut self, visitor: V) -> Result<V::Value, Refused> {
        let mut inner = Shape::Any;
        self.place.push("*");
        let mut entry = OneEntry { shape: &mut inner, place: &self.place, question: self.question, given: false };
        let value = visitor.visit_map(&mut entry)?;
        *self.shape = Shape::Table(Box::new(inner));
        Ok(value)
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Refused> {
        if name.starts_with(PRIVATE) && !name.starts_with(SPANNED) {
            return Err(de::Error::custom("times and dates are not asked for"));
        }
        let is_spanned = name.starts_with(SPANNED);
        let extra = matches!(self.question, Question::With(place) if *place == self.place) && !is_spanned;
        let mut given = Fields {
            fields,
            at: 0,
            is_spanned,
            extra,
            shapes: Vec::with_capacity(fields.len()),
            place: &self.place,
            question: self.question,
        };
        let value = visitor.visit_map(&mut given)?;
        let shapes = given.shapes;
        *self.shape = match is_spanned {
            true => shapes.into_iter().next_back().map_or(Shape::Any, |(_, shape)| shape),
            false => Shape::Struct(shapes),
        };
        Ok(value)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Refused> {
        *self.shape = Shape::Choice(variants);
        let (index, content) = match self.question {
            Question::Variant(place, index, content) if *place == self.place => (*index, Some(content)),
            _ => (0, None),
        };
        visitor.visit_enum(One { name: variants.get(index).copied().unwrap_or_default(), content, asker: &self })
    }
}

/// Entries of a list or tuple.
struct Entries<'a> {
    left: usize,
    shapes: Vec<Shape>,
    place: &'a Place,
    question: &'a Question,
}

impl Entries<'_> {
    fn visit<'de, V: Visitor<'de>>(mut self, visitor: V) -> Result<(V::Value, Vec<Shape>), Refused> {
        let value = visitor.visit_seq(&mut self)?;
        Ok((value, self.shapes))
    }
}

impl<'de> SeqAccess<'de> for &mut Entries<'_> {
    type Error = Refused;

    fn next_element_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>, Refused> {
        if self.left == 0 {
            return Ok(None);
        }
        self.left -= 1;
        let mut shape = Shape::Any;
        let asker = Asker { shape: &mut shape, place: self.place.clone(), question: self.question };
        let value = seed.deserialize(asker)?;
        self.shapes.push(shape);
        Ok(Some(value))
    }
}

/// One entry of a table with keys of the user's own.
struct OneEntry<'a> {
    shape: &'a mut Shape,
    place: &'a Place,
    question: &'a Question,
    given: bool,
}

impl<'de> MapAccess<'de> for &mut OneEntry<'_> {
    type Error = Refused;

    fn next_key_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>, Refused> {
        if std::mem::replace(&mut self.given, true) {
            return Ok(None);
        }
        let mut key = Shape::Any;
        seed.deserialize(Asker { shape: &mut key, place: Vec::new(), question: &Question::Nothing }).map(Some)
    }

    fn next_value_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<S::Value, Refused> {
        seed.deserialize(Asker { shape: self.shape, place: self.place.clone(), question: self.question })
    }
}

/// Fields of a struct.
struct Fields<'a> {
    fields: &'static [&'static str],
    at: usize,
    is_spanned: bool,
    /// A key that no file has is still to be given.
    extra: bool,
    shapes: Vec<(&'static str, Shape)>,
    place: &'a Place,
    question: &'a Question,
}

impl Fields<'_> {
    fn place_of(&self, field: &'static str) -> Place {
        let mut place = self.place.clone();
        if !self.is_spanned {
            place.push(field);
        }
        place
    }
}

impl<'de> MapAccess<'de> for &mut Fields<'_> {
    type Error = Refused;

    fn next_key_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>, Refused> {
        while let Some(field) = self.fields.get(self.at) {
            let left_out = matches!(self.question, Question::Without(place) if *place == self.place_of(field));
            if !left_out || self.is_spanned {
                return seed.deserialize(BorrowedStrDeserializer::new(field)).map(Some);
            }
            self.at += 1;
        }
        if std::mem::take(&mut self.extra) {
            return seed.deserialize(BorrowedStrDeserializer::new("a key that no file has")).map(Some);
        }
        Ok(None)
    }

    fn next_value_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<S::Value, Refused> {
        let mut shape = Shape::Any;
        let field = self.fields.get(self.at).copied();
        self.at += 1;
        let place = field.map_or_else(Vec::new, |field| self.place_of(field));
        let value = seed.deserialize(Asker { shape: &mut shape, place, question: self.question })?;
        if let Some(field) = field {
            self.shapes.push((field, shape));
        }
        Ok(value)
    }
}

/// One variant of an enum.
struct One<'a> {
    name: &'static str,
    /// Where to note what it has beside its name.
    content: Option<&'a RefCell<Option<Shape>>>,
    asker: &'a Asker<'a>,
}

impl One<'_> {
    /// Lets `ask` ask for what the variant has, and notes it.
    fn noted<V>(self, ask: impl FnOnce(Asker<'_>) -> Result<V, Refused>) -> Result<V, Refused> {
        let mut shape = Shape::Any;
        let mut place = self.asker.place.clone();
        place.push(self.name);
        let value = ask(Asker { shape: &mut shape, place, question: self.asker.question });
        if let Some(content) = self.content {
            *content.borrow_mut() = Some(shape);
        }
        value
    }
}

impl<'de> EnumAccess<'de> for One<'_> {
    type Error = Refused;
    type Variant = Self;

    fn variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<(S::Value, Self), Refused> {
        Ok((seed.deserialize(BorrowedStrDeserializer::<Refused>::new(self.name))?, self))
    }
}

impl<'de> VariantAccess<'de> for One<'_> {
    type Error = Refused;

    fn unit_variant(self) -> Result<(), Refused> {
        Ok(())
    }

    fn newtype_variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<S::Value, Refused> {
        self.noted(|asker| seed.deserialize(asker))
    }

    fn tuple_variant<V: Visitor<'de>>(self, count: usize, visitor: V) -> Result<V::Value, Refused> {
        self.noted(|asker| de::Deserializer::deserialize_tuple(asker, count, visitor))
    }

    fn struct_variant<V: Visitor<'de>>(self, fields: &'static [&'static str], visitor: V) -> Result<V::Value, Refused> {
        self.noted(|asker| de::Deserializer::deserialize_struct(asker, "", fields, visitor))
    }
}
