//! Libraries loaded by name, and calls through their function pointers.

use fmi2::{
    fmi2Component, fmi2DoStepTYPE, fmi2EnterInitializationModeTYPE, fmi2ExitInitializationModeTYPE,
    fmi2FMUstate, fmi2FreeInstanceTYPE, fmi2GetFMUstateTYPE, fmi2GetRealTYPE, fmi2InstantiateTYPE,
    fmi2OK, fmi2SetFMUstateTYPE, fmi2SetRealTYPE, fmi2SetupExperimentTYPE,
};
use model_description::ModelDescription;
use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
use std::ffi::CString;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::ptr::{null, null_mut};
use tests::Slave;

/// A loaded library.
pub(crate) struct Library {
    functions: Functions,
    library: libloading::Library,
}

/// Those that both the bicycle and the library in C have.
#[derive(Clone, Copy)]
struct Functions {
    free: fmi2FreeInstanceTYPE,
    step: fmi2DoStepTYPE,
    get: fmi2GetRealTYPE,
}

impl Library {
    /// The bicycle, as cargo built it beside this benchmark.
    pub(crate) fn bicycle() -> Self {
        Self::open(&fmu::built_library().expect("cargo builds it as a dependency"))
    }

    fn open(path: &Path) -> Self {
        // SAFETY: a library of this workspace; the types are the standard's.
        unsafe {
            let library = libloading::Library::new(path).expect("loadable");
            Self {
                functions: Functions {
                    free: Self::function(&library, "fmi2FreeInstance"),
                    step: Self::function(&library, "fmi2DoStep"),
                    get: Self::function(&library, "fmi2GetReal"),
                },
                library,
            }
        }
    }

    /// # Safety
    /// `T` is the type of the function.
    unsafe fn function<T: Copy>(library: &libloading::Library, name: &str) -> T {
        // SAFETY: by contract.
        *unsafe { library.get(name) }.expect("a function of the library")
    }

    /// A new instance.
    pub(crate) fn instantiate(&self, guid: &str) -> Instance<'_> {
        let guid = CString::new(guid).expect("no inner null");
        let callbacks = Slave::callbacks();
        // SAFETY: texts are null-terminated; the library copies the callbacks.
        let c = unsafe {
            let instantiate: fmi2InstantiateTYPE = Self::function(&self.library, "fmi2Instantiate");
            instantiate(
                c"bench".as_ptr(),
                1,
                guid.as_ptr(),
                null(),
                &raw const *callbacks,
                0,
                0,
            )
        };
        assert!(!c.is_null(), "{:?}", Slave::lines());
        self.instance(c)
    }

    /// A new instance of the library in C, which asks for nothing.
    pub(crate) fn instantiate_c(&self) -> Instance<'_> {
        // SAFETY: as it stands in van_der_pol.c.
        let c = unsafe {
            let instantiate: unsafe extern "C" fn() -> fmi2Component =
                Self::function(&self.library, "fmi2Instantiate");
            instantiate()
        };
        self.instance(c)
    }

    fn instance(&self, c: fmi2Component) -> Instance<'_> {
        // SAFETY: the types are the standard's; the library in C lacks these.
        let optional = |name| unsafe { self.library.get::<*const ()>(name).is_ok() };
        Instance {
            library: &self.library,
            functions: self.functions,
            // SAFETY: as above.
            set: optional("fmi2SetReal")
                .then(|| unsafe { Self::function(&self.library, "fmi2SetReal") }),
            c,
            saved: null_mut(),
        }
    }
}

/// An instance.
pub(crate) struct Instance<'a> {
    library: &'a libloading::Library,
    functions: Functions,
    set: Option<fmi2SetRealTYPE>,
    c: fmi2Component,
    saved: fmi2FMUstate,
}

impl Instance<'_> {
    /// From *instantiated* to its first step.
    pub(crate) fn initialize(&self) {
        // SAFETY: the types are the standard's; a live instance.
        unsafe {
            let setup: fmi2SetupExperimentTYPE =
                Library::function(self.library, "fmi2SetupExperiment");
            let enter: fmi2EnterInitializationModeTYPE =
                Library::function(self.library, "fmi2EnterInitializationMode");
            let exit: fmi2ExitInitializationModeTYPE =
                Library::function(self.library, "fmi2ExitInitializationMode");
            assert_eq!(setup(self.c, 0, 0.0, 0.0, 0, 0.0), fmi2OK);
            assert_eq!(enter(self.c), fmi2OK);
            assert_eq!(exit(self.c), fmi2OK);
        }
    }

    pub(crate) fn step(&self, time: f64, h: f64) {
        // SAFETY: a live instance.
        assert_eq!(unsafe { (self.functions.step)(self.c, time, h, 1) }, fmi2OK);
    }

    pub(crate) fn set(&self, reference: u32, value: f64) {
        let set = self.set.expect("a library with fmi2SetReal");
        // SAFETY: one element each.
        let status = unsafe { set(self.c, &raw const reference, 1, &raw const value) };
        assert_eq!(status, fmi2OK);
    }

    pub(crate) fn get(&self, reference: u32) -> f64 {
        let mut value = [0.0];
        self.get_many(&[reference], &mut value);
        value[0]
    }

    pub(crate) fn get_many<const N: usize>(&self, references: &[u32; N], values: &mut [f64; N]) {
        // SAFETY: as many elements as said.
        let status =
            unsafe { (self.functions.get)(self.c, references.as_ptr(), N, values.as_mut_ptr()) };
        assert_eq!(status, fmi2OK);
    }

    /// Saves its state, in the place of the last.
    pub(crate) fn save(&mut self) {
        // SAFETY: the type is the standard's; a live instance and its state.
        unsafe {
            let save: fmi2GetFMUstateTYPE = Library::function(self.library, "fmi2GetFMUstate");
            assert_eq!(save(self.c, &raw mut self.saved), fmi2OK);
        }
    }

    /// Goes back to the saved state.
    pub(crate) fn restore(&mut self) {
        // SAFETY: as above.
        unsafe {
            let restore: fmi2SetFMUstateTYPE = Library::function(self.library, "fmi2SetFMUstate");
            assert_eq!(restore(self.c, self.saved), fmi2OK);
        }
    }
}

impl Drop for Instance<'_> {
    fn drop(&mut self) {
        // SAFETY: freed once, here.
        unsafe { (self.functions.free)(self.c) }
    }
}

/// The folder of what cargo built in this profile.
fn built() -> PathBuf {
    let program = std::env::current_exe().expect("a path");
    program
        .ancestors()
        .nth(2)
        .expect("deps lies in it")
        .to_owned()
}

/// The library in C, compiled now; `None` without a compiler.
pub(crate) fn c_library() -> Option<Library> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/van_der_pol.c");
    let library = built().join(format!("{DLL_PREFIX}van_der_pol_c{DLL_SUFFIX}"));
    let status = Command::new("cc")
        .args(["-O2", "-shared", "-fPIC", "-o"])
        .args([&library, &source])
        .arg("-lm")
        .status();
    status
        .is_ok_and(|status| status.success())
        .then(|| Library::open(&library))
}

/// An example of fmi-export, if it was built.
pub(crate) fn rust_example(name: &str) -> Option<Library> {
    let library = built().join(format!("examples/{DLL_PREFIX}{name}{DLL_SUFFIX}"));
    library.is_file().then(|| Library::open(&library))
}

/// The guid in the golden description of an example.
pub(crate) fn example_guid(name: &str) -> String {
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fmi-export/examples");
    let xml =
        std::fs::read_to_string(examples.join(format!("{name}.xml"))).expect("its golden file");
    ModelDescription::from_xml(&xml)
        .expect("a description")
        .guid
}
