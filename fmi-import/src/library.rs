//! The shared library: the only module that names libloading.

use crate::{Archive, Error};
use fmi2::{
    fmi2DeSerializeFMUstateTYPE, fmi2DoStepTYPE, fmi2EnterInitializationModeTYPE,
    fmi2ExitInitializationModeTYPE, fmi2FreeFMUstateTYPE, fmi2FreeInstanceTYPE,
    fmi2GetBooleanStatusTYPE, fmi2GetBooleanTYPE, fmi2GetDirectionalDerivativeTYPE,
    fmi2GetFMUstateTYPE, fmi2GetIntegerTYPE, fmi2GetRealOutputDerivativesTYPE,
    fmi2GetRealStatusTYPE, fmi2GetRealTYPE, fmi2GetStatusTYPE, fmi2GetStringTYPE,
    fmi2GetTypesPlatformTYPE, fmi2GetVersionTYPE, fmi2InstantiateTYPE, fmi2ResetTYPE,
    fmi2SerializeFMUstateTYPE, fmi2SerializedFMUstateSizeTYPE, fmi2SetBooleanTYPE,
    fmi2SetDebugLoggingTYPE, fmi2SetFMUstateTYPE, fmi2SetIntegerTYPE,
    fmi2SetRealInputDerivativesTYPE, fmi2SetRealTYPE, fmi2SetStringTYPE, fmi2SetupExperimentTYPE,
    fmi2String, fmi2TerminateTYPE, fmi2TypesPlatform, fmi2Version,
};
use libloading::Library;
use model_description::ModelDescription;
use object::{Object, ObjectSegment};
use std::ffi::CStr;
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// An FMU with its library loaded. Instances borrow it, so that the library outlives them, and
/// the unpacked files outlive the library.
#[derive(Debug)]
pub struct Fmu {
    pub(crate) functions: Functions,
    /// An instance returned `fmi2Fatal`: no function of any instance may be called any more
    /// (FMI 2.0 §2.1.3).
    pub(crate) fatal: AtomicBool,
    // dropped after the functions, before the archive
    _library: Library,
    archive: Archive,
}

impl Fmu {
    /// Unpacks the FMU at `path` and loads its library.
    pub fn open(path: &Path) -> Result<Self, Error> {
        Self::load(Archive::open(path)?)
    }

    /// Loads the library of an unpacked FMU. This runs the FMU's code.
    pub fn load(archive: Archive) -> Result<Self, Error> {
        let path = archive.own_library()?;
        let fail = |source| Error::Library {
            path: path.clone(),
            source,
        };
        check_whole(&path)?;
        // SAFETY: the initialisers of the library run; whoever opens an FMU trusts it.
        let library = unsafe { Library::new(&path) }.map_err(fail)?;
        let functions = Functions::load(&library).map_err(fail)?;
        // SAFETY: the type is the standard's; the text is static and null-terminated, or NULL.
        let version = unsafe { text((functions.get_version)()) };
        // "2.0.1" and so on are revisions of the same interface.
        if !version.to_bytes().starts_with(fmi2Version.to_bytes()) {
            return Err(Error::Version {
                path,
                found: version.to_string_lossy().into_owned(),
            });
        }
        if let Some(get_types_platform) = functions.get_types_platform {
            // SAFETY: as for the version.
            let types = unsafe { text(get_types_platform()) };
            if types != fmi2TypesPlatform {
                return Err(Error::TypesPlatform {
                    path,
                    found: types.to_string_lossy().into_owned(),
                });
            }
        }
        Ok(Self {
            functions,
            fatal: AtomicBool::new(false),
            _library: library,
            archive,
        })
    }

    /// The unpacked archive.
    pub fn archive(&self) -> &Archive {
        &self.archive
    }

    /// What modelDescription.xml says.
    pub fn description(&self) -> &ModelDescription {
        self.archive.description()
    }
}

/// Refuses what is no library, or one cut short: the loader maps it all the same, and the process
/// dies where it touches what is not there.
fn check_whole(path: &Path) -> Result<(), Error> {
    let bytes = std::fs::read(path).map_err(|source| Error::File {
        path: path.to_owned(),
        source,
    })?;
    let refuse = |found: String| Error::NoLibrary {
        path: path.to_owned(),
        found,
    };
    let file = object::File::parse(bytes.as_slice())
        .map_err(|error| refuse(format!("other bytes ({error})")))?;
    let ends = file.segments().map(|segment| {
        let (offset, size) = segment.file_range();
        offset.saturating_add(size)
    });
    let (end, found) = (ends.max().unwrap_or(0), bytes.len() as u64);
    if end > found {
        return Err(refuse(format!("{found} of at least {end} bytes")));
    }
    Ok(())
}

/// The text, empty for NULL.
///
/// # Safety
/// `text` is NULL, or null-terminated and static.
unsafe fn text(text: fmi2String) -> &'static CStr {
    if text.is_null() {
        return c"";
    }
    // SAFETY: by contract.
    unsafe { CStr::from_ptr(text) }
}

macro_rules! functions {
    (
        required { $($field:ident: $type:ty = $name:literal;)* }
        optional { $($maybe:ident: $maybe_type:ty = $maybe_name:literal;)* }
    ) => {
        /// The functions of the library; valid as long as it is loaded.
        #[derive(Debug)]
        pub(crate) struct Functions {
            $(pub(crate) $field: $type,)*
            $(pub(crate) $maybe: Option<$maybe_type>,)*
        }

        impl Functions {
            fn load(library: &Library) -> Result<Self, libloading::Error> {
                Ok(Self {
                    // SAFETY: the types are those the standard gives to these names; `Fmu` keeps
                    // the library loaded as long as the pointers exist.
                    $($field: *unsafe { library.get::<$type>($name)? },)*
                    // SAFETY: as above.
                    $($maybe: unsafe { library.get::<$maybe_type>($maybe_name) }
                        .ok()
                        .map(|function| *function),)*
                })
            }
        }
    };
}

functions! {
    required {
        get_version: fmi2GetVersionTYPE = "fmi2GetVersion";
        instantiate: fmi2InstantiateTYPE = "fmi2Instantiate";
        free_instance: fmi2FreeInstanceTYPE = "fmi2FreeInstance";
        setup_experiment: fmi2SetupExperimentTYPE = "fmi2SetupExperiment";
        enter_initialization_mode: fmi2EnterInitializationModeTYPE = "fmi2EnterInitializationMode";
        exit_initialization_mode: fmi2ExitInitializationModeTYPE = "fmi2ExitInitializationMode";
        terminate: fmi2TerminateTYPE = "fmi2Terminate";
        reset: fmi2ResetTYPE = "fmi2Reset";
        get_real: fmi2GetRealTYPE = "fmi2GetReal";
        get_integer: fmi2GetIntegerTYPE = "fmi2GetInteger";
        get_boolean: fmi2GetBooleanTYPE = "fmi2GetBoolean";
        get_string: fmi2GetStringTYPE = "fmi2GetString";
        set_real: fmi2SetRealTYPE = "fmi2SetReal";
        set_integer: fmi2SetIntegerTYPE = "fmi2SetInteger";
        set_boolean: fmi2SetBooleanTYPE = "fmi2SetBoolean";
        set_string: fmi2SetStringTYPE = "fmi2SetString";
        do_step: fmi2DoStepTYPE = "fmi2DoStep";
    }
    // Every FMU is to have these too, but some lack what they declare no capability for.
    optional {
        get_types_platform: fmi2GetTypesPlatformTYPE = "fmi2GetTypesPlatform";
        set_debug_logging: fmi2SetDebugLoggingTYPE = "fmi2SetDebugLogging";
        get_fmu_state: fmi2GetFMUstateTYPE = "fmi2GetFMUstate";
        set_fmu_state: fmi2SetFMUstateTYPE = "fmi2SetFMUstate";
        free_fmu_state: fmi2FreeFMUstateTYPE = "fmi2FreeFMUstate";
        serialized_fmu_state_size: fmi2SerializedFMUstateSizeTYPE = "fmi2SerializedFMUstateSize";
        serialize_fmu_state: fmi2SerializeFMUstateTYPE = "fmi2SerializeFMUstate";
        deserialize_fmu_state: fmi2DeSerializeFMUstateTYPE = "fmi2DeSerializeFMUstate";
        get_directional_derivative: fmi2GetDirectionalDerivativeTYPE = "fmi2GetDirectionalDerivative";
        set_real_input_derivatives: fmi2SetRealInputDerivativesTYPE = "fmi2SetRealInputDerivatives";
        get_real_output_derivatives: fmi2GetRealOutputDerivativesTYPE = "fmi2GetRealOutputDerivatives";
        get_status: fmi2GetStatusTYPE = "fmi2GetStatus";
        get_real_status: fmi2GetRealStatusTYPE = "fmi2GetRealStatus";
        get_boolean_status: fmi2GetBooleanStatusTYPE = "fmi2GetBooleanStatus";
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_library_cut_short_is_refused() {
        let whole = std::env::current_exe().expect("a running test");
        check_whole(&whole).expect("all of it is there");
        let bytes = std::fs::read(&whole).expect("readable");
        let folder = tempfile::tempdir().expect("temporary folder");
        let cut = folder.path().join("cut");
        for length in [0, 100, 5000, bytes.len() / 2] {
            std::fs::write(&cut, &bytes[..length]).expect("writable");
            let error = check_whole(&cut).expect_err("a part is missing");
            assert!(matches!(error, Error::NoLibrary { .. }), "{error}");
        }
    }
}
