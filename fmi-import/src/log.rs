//! Lines of an FMU's log.

use crate::Status;
use model_description::{ModelDescription, VariableType};
use std::fmt;

/// A line of an FMU's log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LogLine {
    /// How serious.
    pub status: Status,
    /// One of the description's log categories, if the FMU keeps to them.
    pub category: String,
    /// The message, its placeholders filled in.
    pub message: String,
}

impl fmt::Display for LogLine {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "[{}] {}", self.category, self.message)
    }
}

impl LogLine {
    /// Variables by name: a message may refer to one as `#r12#`, the letter its type and the
    /// number its value reference, and writes `#` as `##` (FMI 2.0 §2.1.5).
    pub(crate) fn with_names(mut self, description: &ModelDescription) -> Self {
        if !self.message.contains('#') {
            return self;
        }
        let mut named = String::new();
        let mut rest = self.message.as_str();
        while let Some((before, after)) = rest.split_once('#') {
            named.push_str(before);
            let reference = after.split_once('#');
            if let Some(after) = after.strip_prefix('#') {
                named.push('#');
                rest = after;
            } else if let Some((name, after)) =
                reference.and_then(|(code, after)| Some((variable(description, code)?, after)))
            {
                named.push_str(name);
                rest = after;
            } else {
                // not as the standard has it: left as it is
                named.push('#');
                rest = after;
            }
        }
        named.push_str(rest);
        self.message = named;
        self
    }
}

/// The name behind `r12`.
fn variable<'a>(description: &'a ModelDescription, code: &str) -> Option<&'a str> {
    let letter = code.chars().next()?;
    let reference: u32 = code[letter.len_utf8()..].parse().ok()?;
    let is_meant = |of: &VariableType| {
        matches!(
            (letter, of),
            ('r', VariableType::Real(_))
                | ('i', VariableType::Integer(_) | VariableType::Enumeration(_))
                | ('b', VariableType::Boolean(_))
                | ('s', VariableType::String(_))
        )
    };
    description
        .variables
        .iter()
        .find(|v| v.value_reference == reference && is_meant(&v.variable_type))
        .map(|v| v.name.as_str())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn references_in_messages_become_names() {
        let xml = "<fmiModelDescription fmiVersion=\"2.0\" modelName=\"M\" guid=\"\">\
                   <ModelVariables>\
                   <ScalarVariable name=\"speed\" valueReference=\"7\"><Real/></ScalarVariable>\
                   <ScalarVariable name=\"gear\" valueReference=\"7\"><Integer/></ScalarVariable>\
                   </ModelVariables></fmiModelDescription>";
        let description = ModelDescription::from_xml(xml).expect("a description");
        for (message, expected) in [
            ("#r7# is negative", "speed is negative"),
            ("set #i7# before #r7#.", "set gear before speed."),
            ("bolt ##3", "bolt #3"),
            ("no #r8#, #é7#, #7# or #", "no #r8#, #é7#, #7# or #"),
            ("####", "##"),
        ] {
            let line = LogLine {
                status: Status::Error,
                category: String::new(),
                message: message.to_owned(),
            };
            assert_eq!(line.with_names(&description).message, expected);
        }
    }
}
