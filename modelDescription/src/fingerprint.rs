//! The guid as a hash of what the binary must agree with.

use crate::{ModelDescription, VariableType};
use sha2::{Digest, Sha256};

impl ModelDescription {
    /// A guid `{8-4-4-4-12}` from the SHA-256 of this description without its guid, start
    /// values, date and tool: descriptions that differ only in those fit the same binary.
    ///
    /// # Panics
    /// Never for values this crate can write as XML: the serialiser fails on none of these types.
    pub fn fingerprint(&self) -> String {
        let mut essence = Self {
            guid: String::new(),
            generation_tool: None,
            generation_date_and_time: None,
            ..self.clone()
        };
        for variable in &mut essence.variables {
            match &mut variable.variable_type {
                VariableType::Real(real) => real.start = None,
                VariableType::Integer(integer) => integer.start = None,
                VariableType::Boolean(boolean) => boolean.start = None,
                VariableType::String(string) => string.start = None,
                VariableType::Enumeration(enumeration) => enumeration.start = None,
            }
        }
        let xml = essence.to_xml().expect("these types are always writable");
        let hash = format!("{:x}", Sha256::digest(xml));
        format!(
            "{{{}-{}-{}-{}-{}}}",
            &hash[..8],
            &hash[8..12],
            &hash[12..16],
            &hash[16..20],
            &hash[20..32]
        )
    }
}
