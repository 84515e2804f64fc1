//! What a row of a table says: [`Quantity`] and its [`Unit`], and the macro that makes both a
//! struct and a table of the same rows.

/// An SI unit: how it is written, and its exponents of kilogram, metre, second and radian.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Unit {
    /// As written in files and on the command line, e.g. `N.m.s/rad`.
    pub symbol: &'static str,
    /// Exponent of the kilogram.
    pub kg: i8,
    /// Exponent of the metre.
    pub m: i8,
    /// Exponent of the second.
    pub s: i8,
    /// Exponent of the radian (a number one; carried because FMI carries it).
    pub rad: i8,
}

macro_rules! units {
    ($($name:ident = $symbol:literal $kg:literal $m:literal $s:literal $rad:literal;)*) => {
        $(
            #[doc = concat!("`", $symbol, "`.")]
            pub const $name: Unit = Unit { symbol: $symbol, kg: $kg, m: $m, s: $s, rad: $rad };
        )*
        /// Every unit of the tables.
        pub static UNITS: &[Unit] = &[$($name),*];
    };
}

units! {
    // name             symbol            kg  m  s rad
    ONE               = "1"               0  0  0  0;
    KG                = "kg"              1  0  0  0;
    M                 = "m"               0  1  0  0;
    S                 = "s"               0  0  1  0;
    HZ                = "Hz"              0  0 -1  0;
    RAD               = "rad"             0  0  0  1;
    RAD_PER_S         = "rad/s"           0  0 -1  1;
    RAD_PER_S2        = "rad/s2"          0  0 -2  1;
    PER_RAD           = "1/rad"           0  0  0 -1;
    M_PER_S           = "m/s"             0  1 -1  0;
    M_PER_S2          = "m/s2"            0  1 -2  0;
    KG_M2             = "kg.m2"           1  2  0  0;
    N                 = "N"               1  1 -2  0;
    N_PER_S           = "N/s"             1  1 -3  0;
    N_M               = "N.m"             1  2 -2  0;
    N_M_PER_RAD       = "N.m/rad"         1  2 -2 -1;
    N_M_S_PER_RAD     = "N.m.s/rad"       1  2 -1 -1;
    N_S_PER_RAD       = "N.s/rad"         1  1 -1 -1;
    N_S2_PER_RAD      = "N.s2/rad"        1  1  0 -1;
}

/// When a row may change.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Variability {
    /// Set before the simulation starts, constant from then on.
    Fixed,
    /// May be changed between steps and acts from there on.
    Tunable,
    /// Changes with time: states, inputs, outputs.
    Continuous,
}

/// One row of a table: everything that is known of a quantity apart from its value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quantity {
    /// The name, the same everywhere: field, file, command line, FMU.
    pub name: &'static str,
    /// The symbol of the paper.
    pub symbol: &'static str,
    /// The SI unit.
    pub unit: Unit,
    /// Nominal or start value, SI.
    pub nominal: f64,
    /// Smallest value the doors let in, SI.
    pub min: f64,
    /// Largest value the doors let in, SI.
    pub max: f64,
    /// What the literature measured, SI: the yardstick of a verdict.
    pub measured: Option<(f64, f64)>,
    /// When it may change.
    pub variability: Variability,
    /// What it is.
    pub what: &'static str,
    /// Where its value comes from.
    pub source: &'static str,
}

impl Quantity {
    /// Whether `value` [SI] lies in the row's range; NaN does not.
    pub fn admits(&self, value: f64) -> bool {
        (self.min..=self.max).contains(&value)
    }
}

/// The index of the row of `table` called `name`, also at compile time.
pub(crate) const fn position(table: &[Quantity], name: &str) -> Option<usize> {
    let mut i = 0;
    while i < table.len() {
        if same(table[i].name.as_bytes(), name.as_bytes()) {
            return Some(i);
        }
        i += 1;
    }
    None
}

const fn same(a: &[u8], b: &[u8]) -> bool {
    if a.len() != b.len() {
        return false;
    }
    let mut i = 0;
    while i < a.len() {
        if a[i] != b[i] {
            return false;
        }
        i += 1;
    }
    true
}

/// Vectors that an integrator can step along.
pub trait Vector<T>: Copy {
    /// `self + h · slope`.
    #[must_use]
    fn along(self, h: T, slope: &Self) -> Self;
}

impl<T: Copy, A: Vector<T>, B: Vector<T>> Vector<T> for (A, B) {
    #[inline(always)]
    fn along(self, h: T, slope: &Self) -> Self {
        (self.0.along(h, &slope.0), self.1.along(h, &slope.1))
    }
}

/// Makes a struct generic over the scalar and its `TABLE` from the same rows:
/// `name: "symbol" UNIT = nominal, in [min, max], (measured [a, b],)? "what", "source";`
/// in groups `Fixed { … }`, `Tunable { … }` or `Continuous { … }`.
macro_rules! rows {
    (
        $(#[$outer:meta])*
        $Name:ident;
        $(
            $variability:ident {
                $(
                    $field:ident: $symbol:literal $unit:ident = $nominal:expr, in [$min:expr, $max:expr],
                    $(measured [$low:expr, $high:expr],)?
                    $what:literal, $source:literal;
                )+
            }
        )+
    ) => {
        $(#[$outer])*
        #[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
        pub struct $Name<T = f64> {
            $($(
                #[doc = concat!($what, ", ", $symbol, " [", stringify!($unit), "].")]
                pub $field: T,
            )+)+
        }

        impl $Name {
            /// The rows in the order of the fields.
            pub const TABLE: &'static [$crate::quantity::Quantity] = &[$($(
                $crate::quantity::Quantity {
                    name: stringify!($field),
                    symbol: $symbol,
                    unit: $crate::quantity::$unit,
                    nominal: $nominal,
                    min: $min,
                    max: $max,
                    measured: $crate::quantity::rows!(@measured $($low, $high)?),
                    variability: $crate::quantity::Variability::$variability,
                    what: $what,
                    source: $source,
                },
            )+)+];

            /// How many rows there are.
            pub const LEN: usize = Self::TABLE.len();

            /// Zero in every row: no change, no slope.
            pub const ZERO: Self = Self { $($($field: 0.0,)+)+ };

            /// The index of the row called `name`.
            pub const fn index(name: &str) -> Option<usize> {
                $crate::quantity::position(Self::TABLE, name)
            }

            /// Whether every value is the other's to the last bit. Without a branch for each: it is
            /// asked at every step of a co-simulation.
            pub fn has_bits_of(&self, other: &Self) -> bool {
                let differing = 0 $($(| (self.$field.to_bits() ^ other.$field.to_bits()))+)+;
                differing == 0
            }
        }

        impl<T: Copy> $Name<T> {
            /// The values in the order of the table.
            pub fn to_array(&self) -> [T; $Name::LEN] {
                [$($(self.$field,)+)+]
            }

            /// From values in the order of the table.
            pub fn from_array(values: [T; $Name::LEN]) -> Self {
                let [$($($field,)+)+] = values;
                Self { $($($field,)+)+ }
            }

            /// The value of row `index` of the table.
            pub fn get(&self, index: usize) -> T {
                self.to_array()[index]
            }

            /// Sets row `index` of the table.
            pub fn set(&mut self, index: usize, value: T) {
                let mut values = self.to_array();
                values[index] = value;
                *self = Self::from_array(values);
            }

            /// The same rows over another scalar.
            pub fn map<U: Copy>(&self, mut f: impl FnMut(T) -> U) -> $Name<U> {
                $Name { $($($field: f(self.$field),)+)+ }
            }

            /// The same rows over another scalar, each made of two.
            pub fn zip<U: Copy, V: Copy>(&self, other: &$Name<U>, mut f: impl FnMut(T, U) -> V) -> $Name<V> {
                $Name { $($($field: f(self.$field, other.$field),)+)+ }
            }
        }

        impl<T: $crate::real::Real> Default for $Name<T> {
            /// The nominal values.
            fn default() -> Self {
                Self { $($($field: T::from($nominal),)+)+ }
            }
        }

        impl<T: $crate::real::Real> $crate::quantity::Vector<T> for $Name<T> {
            #[inline(always)]
            fn along(self, h: T, slope: &Self) -> Self {
                Self { $($($field: self.$field + h * slope.$field,)+)+ }
            }
        }
    };
    (@measured) => { None };
    (@measured $low:expr, $high:expr) => { Some(($low, $high)) };
}
pub(crate) use rows;
