//! The shared library: the only module that names libloading.

use crate::{Archive, Error};
use fmi2::{
    fmi2DoStepTYPE, fmi2EnterInitializationModeTYPE, fmi2ExitInitializationModeTYPE,
    fmi2FreeInstanceTYPE, fmi2GetBooleanStatusTYPE, fmi2GetBooleanTYPE, fmi2GetIntegerTYPE,
    fmi2GetRealStatusTYPE, fmi2GetRealTYPE, fmi2GetStringTYPE, fmi2GetVersionTYPE,
    fmi2InstantiateTYPE, fmi2ResetTYPE, fmi2SetBooleanTYPE, fmi2SetIntegerTYPE, fmi2SetRealTYPE,
    fmi2SetStringTYPE, fmi2SetupExperimentTYPE, fmi2TerminateTYPE,
};
use libloading::Library;
use model_description::ModelDescription;
use std::ffi::CStr;
use std::path::Path;

/// An FMU with its library loaded. Instances borrow it, so that the library outlives them, and
/// the unpacked files outlive the library.
#[derive(Debug)]
pub struct Fmu {
    pub(crate) functions: Functions,
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
        // SAFETY: the initialisers of the library run; whoever opens an FMU trusts it.
        let library = unsafe { Library::new(&path) }.map_err(fail)?;
        let functions = Functions::load(&library).map_err(fail)?;
        // SAFETY: the type is the standard's; the text is static and null-terminated, or NULL.
        let version = unsafe {
            let version = (functions.get_version)();
            if version.is_null() {
                c""
            } else {
                CStr::from_ptr(version)
            }
        };
        // "2.0.1" and so on are revisions of the same interface.
        if !version.to_bytes().starts_with(b"2.0") {
            return Err(Error::Version {
                path,
                found: version.to_string_lossy().into_owned(),
            });
        }
        Ok(Self {
            functions,
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

macro_rules! functions {
    ($($field:ident: $type:ty = $name:literal;)*) => {
        /// The functions of the library; valid as long as it is loaded.
        #[derive(Debug)]
        pub(crate) struct Functions {
            $(pub(crate) $field: $type,)*
        }

        impl Functions {
            fn load(library: &Library) -> Result<Self, libloading::Error> {
                Ok(Self {
                    // SAFETY: the types are those the standard gives to these names; `Fmu` keeps
                    // the library loaded as long as the pointers exist.
                    $($field: *unsafe { library.get::<$type>($name)? },)*
                })
            }
        }
    };
}

functions! {
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
    get_real_status: fmi2GetRealStatusTYPE = "fmi2GetRealStatus";
    get_boolean_status: fmi2GetBooleanStatusTYPE = "fmi2GetBooleanStatus";
}
