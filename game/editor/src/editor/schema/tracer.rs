//! A deserializer that makes values up, and notes what is asked for.

use super::Shape;
use serde::de::{self, DeserializeSeed, Deserializer, EnumAccess, MapAccess, SeqAccess, VariantAccess, Visitor};
use std::fmt;

/// Deeper values are left out: types may contain themselves.
const MAX_DEPTH: usize = 9;

/// Hands out made-up values, and notes what is asked for.
pub struct Tracer<'a> {
    shape: &'a mut Shape,
    depth: usize,
    /// At the top: the only field that is given.
    only: Option<&'static str>,
}

/// Why a value was not made up.
#[derive(Debug)]
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

impl<'a> Tracer<'a> {
    /// Notes into a shape; of a structure at the top, only the field of that name is given.
    pub fn of(shape: &'a mut Shape, only: Option<&'static str>) -> Self {
        Self { shape, depth: 0, only }
    }

    fn inside<'b>(&self, shape: &'b mut Shape) -> Tracer<'b> {
        Tracer { shape, depth: self.depth + 1, only: None }
    }
}

macro_rules! numbers {
    ($($deserialize:ident $visit:ident $shape:expr),* $(,)?) => {
        $(fn $deserialize<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refused> {
            *self.shape = $shape;
            visitor.$visit(Default::default())
        })*
    };
}

impl<'de> Deserializer<'de> for Tracer<'_> {
    type Error = Refused;

    numbers! {
        deserialize_bool visit_bool Shape::Bool,
        deserialize_i8 visit_i8 Shape::Integer(true),
        deserialize_i16 visit_i16 Shape::Integer(true),
        deserialize_i32 visit_i32 Shape::Integer(true),
        deserialize_i64 visit_i64 Shape::Integer(true),
        deserialize_u8 visit_u8 Shape::Integer(false),
        deserialize_u16 visit_u16 Shape::Integer(false),
        deserialize_u32 visit_u32 Shape::Integer(false),
        deserialize_u64 visit_u64 Shape::Integer(false),
        deserialize_f32 visit_f32 Shape::Float(true),
        deserialize_f64 visit_f64 Shape::Float(false),
    }

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refused> {
        let name = std::any::type_name::<V::Value>();
        *self.shape = Shape::Custom(name.rsplit("::").next().unwrap_or(name).trim_end_matches('>').to_owned());
        // Visitors of this kind take several forms; which ones, they tell in words alone.
        let wanted = Expected(&visitor).to_string();
        if wanted.contains("name") || wanted.contains("path") || wanted.contains("text") {
            visitor.visit_str("")
        } else if wanted.contains("three angles") || wanted.contains("(x, y, z)") && !wanted.contains("number") {
            visitor.visit_seq(Zeros(3))
        } else {
            visitor.visit_f64(0.0)
        }
    }

    fn deserialize_str<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refused> {
        *self.shape = Shape::Text;
        visitor.visit_str("")
    }
    fn deserialize_string<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refused> {
        self.deserialize_str(visitor)
    }
    fn deserialize_char<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refused> {
        *self.shape = Shape::Text;
        visitor.visit_char(' ')
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refused> {
        if self.depth >= MAX_DEPTH {
            *self.shape = Shape::Option(Box::new(Shape::Unit));
            return visitor.visit_none();
        }
        if !matches!(self.shape, Shape::Option(_)) {
            *self.shape = Shape::Option(Box::default());
        }
        let depth = self.depth + 1;
        let Shape::Option(inner) = self.shape else { return visitor.visit_none() };
        visitor.visit_some(Tracer { shape: inner, depth, only: None })
    }

    fn deserialize_unit<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refused> {
        *self.shape = Shape::Unit;
        visitor.visit_unit()
    }
    fn deserialize_unit_struct<V: Visitor<'de>>(self, _: &'static str, visitor: V) -> Result<V::Value, Refused> {
        self.deserialize_unit(visitor)
    }
    fn deserialize_newtype_struct<V: Visitor<'de>>(self, _: &'static str, visitor: V) -> Result<V::Value, Refused> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refused> {
        if self.depth >= MAX_DEPTH {
            *self.shape = Shape::List(Box::new(Shape::Unit));
            return visitor.visit_seq(Zeros(0));
        }
        if !matches!(self.shape, Shape::List(_)) {
            *self.shape = Shape::List(Box::default());
        }
        let depth = self.depth + 1;
        let Shape::List(inner) = self.shape else { return visitor.visit_seq(Zeros(0)) };
        visitor.visit_seq(Elements { shapes: std::slice::from_mut(inner), next: 0, depth })
    }

    fn deserialize_tuple<V: Visitor<'de>>(self, len: usize, visitor: V) -> Result<V::Value, Refused> {
        if !matches!(self.shape, Shape::Tuple(_)) {
            *self.shape = Shape::Tuple(vec![Shape::Unknown; len]);
        }
        let depth = self.depth + 1;
        let Shape::Tuple(shapes) = self.shape else { return visitor.visit_seq(Zeros(len)) };
        visitor.visit_seq(Elements { shapes, next: 0, depth })
    }
    fn deserialize_tuple_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        len: usize,
        visitor: V,
    ) -> Result<V::Value, Refused> {
        self.deserialize_tuple(len, visitor)
    }

    fn deserialize_map<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refused> {
        if !matches!(self.shape, Shape::Map(_)) {
            *self.shape = Shape::Map(Box::default());
        }
        let depth = self.depth + 1;
        let Shape::Map(inner) = self.shape else { return visitor.visit_unit() };
        if depth > MAX_DEPTH {
            **inner = Shape::Unit;
        }
        let given = (depth <= MAX_DEPTH).then_some("name");
        visitor.visit_map(Entries {
            shapes: vec![(given.unwrap_or_default(), &mut **inner)],
            next: 0,
            depth,
            skip: given.is_none(),
        })
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Refused> {
        if !matches!(self.shape, Shape::Struct(..)) {
            let fields = fields.iter().map(|field| (*field, Shape::Unknown)).collect();
            *self.shape = Shape::Struct(name.to_owned(), fields);
        }
        let (depth, only) = (self.depth + 1, self.only);
        let Shape::Struct(_, shapes) = self.shape else { return visitor.visit_unit() };
        if depth > MAX_DEPTH {
            shapes.iter_mut().for_each(|(_, shape)| *shape = Shape::Unit);
        }
        let wanted = |field: &str| depth <= MAX_DEPTH && only.is_none_or(|only| only == field);
        let shapes = shapes.iter_mut().filter(|(field, _)| wanted(field)).map(|(f, shape)| (*f, shape)).collect();
        visitor.visit_map(Entries { shapes, next: 0, depth, skip: false })
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        name: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Refused> {
        if !matches!(self.shape, Shape::Enum(..)) {
            let variants = variants.iter().map(|variant| (*variant, Shape::Unknown)).collect();
            *self.shape = Shape::Enum(name.to_owned(), variants);
        }
        let depth = self.depth + 1;
        let Shape::Enum(_, shapes) = self.shape else { return Err(Refused("no enum".into())) };
        let next = shapes.iter().position(|(_, shape)| !shape.is_complete()).unwrap_or(0);
        match shapes.get_mut(next) {
            Some((variant, shape)) => visitor.visit_enum(Variant { name: variant, shape, depth }),
            None => Err(Refused("an enum without variants".into())),
        }
    }

    fn deserialize_identifier<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refused> {
        visitor.visit_str("")
    }
    fn deserialize_ignored_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refused> {
        visitor.visit_unit()
    }
    fn deserialize_bytes<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refused> {
        visitor.visit_bytes(&[])
    }
    fn deserialize_byte_buf<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refused> {
        visitor.visit_bytes(&[])
    }
}

/// What a visitor says that it wants.
struct Expected<'a, V>(&'a V);

impl<'de, V: Visitor<'de>> fmt::Display for Expected<'_, V> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.expecting(f)
    }
}

/// So many zeros.
struct Zeros(usize);

impl<'de> SeqAccess<'de> for Zeros {
    type Error = Refused;
    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, Refused> {
        let Some(left) = self.0.checked_sub(1) else { return Ok(None) };
        self.0 = left;
        seed.deserialize(Tracer { shape: &mut Shape::Unknown, depth: 0, only: None }).map(Some)
    }
}

struct Elements<'a> {
    shapes: &'a mut [Shape],
    next: usize,
    depth: usize,
}

impl<'de> SeqAccess<'de> for Elements<'_> {
    type Error = Refused;
    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, Refused> {
        let Some(shape) = self.shapes.get_mut(self.next) else { return Ok(None) };
        self.next += 1;
        seed.deserialize(Tracer { shape, depth: self.depth, only: None }).map(Some)
    }
}

struct Entries<'a> {
    shapes: Vec<(&'static str, &'a mut Shape)>,
    next: usize,
    depth: usize,
    skip: bool,
}

impl<'de> MapAccess<'de> for Entries<'_> {
    type Error = Refused;
    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, Refused> {
        match self.shapes.get(self.next) {
            Some((name, _)) if !self.skip => seed.deserialize(de::value::StrDeserializer::new(name)).map(Some),
            _ => Ok(None),
        }
    }
    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, Refused> {
        let (depth, next) = (self.depth, self.next);
        self.next += 1;
        match self.shapes.get_mut(next) {
            Some((_, shape)) => seed.deserialize(Tracer { shape, depth, only: None }),
            None => Err(Refused("a value without a key".into())),
        }
    }
}

struct Variant<'a> {
    name: &'static str,
    shape: &'a mut Shape,
    depth: usize,
}

impl<'de, 'a> EnumAccess<'de> for Variant<'a> {
    type Error = Refused;
    type Variant = Tracer<'a>;
    fn variant_seed<V: DeserializeSeed<'de>>(self, seed: V) -> Result<(V::Value, Tracer<'a>), Refused> {
        let value = seed.deserialize(de::value::StrDeserializer::<Refused>::new(self.name))?;
        Ok((value, Tracer { shape: self.shape, depth: self.depth, only: None }))
    }
}

impl<'de> VariantAccess<'de> for Tracer<'_> {
    type Error = Refused;
    fn unit_variant(self) -> Result<(), Refused> {
        *self.shape = Shape::Unit;
        Ok(())
    }
    fn newtype_variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<T::Value, Refused> {
        let inside = self.inside(&mut Shape::Unknown).depth;
        seed.deserialize(Tracer { shape: self.shape, depth: inside, only: None })
    }
    fn tuple_variant<V: Visitor<'de>>(self, len: usize, visitor: V) -> Result<V::Value, Refused> {
        self.deserialize_tuple(len, visitor)
    }
    fn struct_variant<V: Visitor<'de>>(self, fields: &'static [&'static str], visitor: V) -> Result<V::Value, Refused> {
        self.deserialize_struct("", fields, visitor)
    }
}
