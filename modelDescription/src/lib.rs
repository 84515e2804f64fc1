//! modelDescription.xml of FMI 2.0 as types.
