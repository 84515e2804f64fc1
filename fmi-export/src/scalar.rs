//! Values of one type on their way through the interface.

use crate::{Function, Kind, Value};

/// An enumeration: its name, and those of its choices with what they mean, numbered from 1.
pub type Choices = (&'static str, &'static [(&'static str, &'static str)]);

/// A Rust type that carries values through the interface.
pub trait Scalar: Clone {
    /// Which functions carry it.
    const KIND: Kind;
    /// The function that reads it.
    const GET: Function;
    /// The function that writes it.
    const SET: Function;
    /// Name of the type and of its choices, numbered from 1, for an enumeration.
    fn choices() -> Option<Choices> {
        None
    }
    /// The number that a range can be asked of.
    fn number(&self) -> Option<f64>;
    /// As a value of any type.
    fn into_value(self) -> Value;
    /// Back, if it is of this type.
    fn from_value(value: Value) -> Result<Self, Value>;
}

macro_rules! scalar {
    ($($type:ty as $variant:ident, $get:ident, $set:ident, $number:expr;)*) => {
        $(
            impl Scalar for $type {
                const KIND: Kind = Kind::$variant;
                const GET: Function = Function::$get;
                const SET: Function = Function::$set;
                #[inline]
                fn number(&self) -> Option<f64> {
                    let number: fn(&Self) -> Option<f64> = $number;
                    number(self)
                }
                #[inline]
                fn into_value(self) -> Value {
                    Value::$variant(self)
                }
                #[inline]
                fn from_value(value: Value) -> Result<Self, Value> {
                    match value {
                        Value::$variant(value) => Ok(value),
                        other => Err(other),
                    }
                }
            }
        )*
    };
}

scalar! {
    f64 as Real, GetReal, SetReal, |&value| Some(value);
    i32 as Integer, GetInteger, SetInteger, |&value| Some(value.into());
    bool as Boolean, GetBoolean, SetBoolean, |_| None;
    String as String, GetString, SetString, |_| None;
}
