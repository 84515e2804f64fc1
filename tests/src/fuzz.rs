//! What is done with bytes from outside. The fuzzer looks for some that make it panic, hang or
//! differ; the tests replay what it found worth keeping.

use fmi_export::{Experiment, Flow, Instance, Model};
use fmi_import::Archive;
use model_description::ModelDescription;
use sha2::{Digest, Sha256};
use std::io::{Cursor, Write};
use std::ptr::null_mut;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// Reads a description. What can be read can be written and read again, to the same value.
/// Returns whether it could be read.
pub fn description(bytes: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return false;
    };
    let Ok(read) = ModelDescription::from_xml(text) else {
        return false;
    };
    let written = read.to_xml().expect("what was read can be written");
    let again = ModelDescription::from_xml(&written).expect("what was written can be read");
    // NaN is not equal to itself
    assert!(
        again == read || format!("{read:?}").contains("NaN"),
        "{read:?}"
    );
    assert_eq!(again.to_xml().expect("writable"), written);
    assert_eq!(again.fingerprint(), read.fingerprint());
    true
}

/// Opens an archive and looks into it, without loading its library. The first byte says whether
/// the rest is one, or is to be packed into one. Returns whether it could be opened.
pub fn archive(bytes: &[u8]) -> bool {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("fuzz.fmu");
    match bytes.split_first() {
        Some((b'p', parts)) => std::fs::write(&path, packed(parts)),
        Some((_, rest)) => std::fs::write(&path, rest),
        None => return false,
    }
    .expect("writable");
    let archive = Archive::open(&path);
    if let Ok(archive) = &archive {
        let _ = archive.inspect();
    }
    let left = std::fs::read_dir(folder.path()).expect("readable").count();
    assert_eq!(left, 1, "files escaped");
    archive.is_ok()
}

/// An archive whose entries are the lines of `parts`: kind (`l` a symbolic link, else a file) and
/// name up to the first blank, then the content; `\0` parts the entries. So the checksums are right,
/// and the names and what is in the files gets the attention.
fn packed(parts: &[u8]) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for entry in parts.split(|&byte| byte == 0) {
        let (name, content) = entry
            .iter()
            .position(|&byte| byte == b' ')
            .map_or((entry, &[][..]), |at| (&entry[..at], &entry[at + 1..]));
        let Some((kind, name)) = name.split_first() else {
            continue;
        };
        let name = String::from_utf8_lossy(name).into_owned();
        let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
        // Two entries of one name are refused by this writer.
        let _ = if *kind == b'l' {
            zip.add_symlink(name, String::from_utf8_lossy(content), options)
        } else {
            zip.start_file(name, options)
                .and_then(|()| Ok(zip.write_all(content)?))
        };
    }
    zip.finish().expect("in memory").into_inner()
}

/// Length of the SHA-256 at the end of a serialised state.
const CHECKSUM: usize = 32;

/// `bytes` with their last 32 made the checksum of all before.
pub fn with_checksum(bytes: &[u8]) -> Vec<u8> {
    let body = &bytes[..bytes.len().saturating_sub(CHECKSUM)];
    [body, &Sha256::digest(body)].concat()
}

/// An instance that is given serialised states.
pub struct Reader<M: Model> {
    instance: Instance<M>,
    variables: u32,
    /// What its serialised states begin with, up to the guid.
    header: Vec<u8>,
}

impl<M: Model> Reader<M> {
    /// An instance that was given none yet.
    pub fn new() -> Self {
        let instance = Instance::<M>::new().expect("the description is sound");
        let mut header = serialized(&instance);
        let description = M::description();
        let guid = description.fingerprint();
        let at = header
            .windows(guid.len())
            .position(|window| window == guid.as_bytes());
        header.truncate(at.expect("a guid") + guid.len());
        Self {
            instance,
            variables: description.variables.len() as u32,
            header,
        }
    }

    /// Reads a serialised state of which only what follows the guid is given, without checksum.
    pub fn read_body(&mut self, body: &[u8]) -> bool {
        let bytes = [&self.header, body, &[0; CHECKSUM]].concat();
        self.read(&with_checksum(&bytes))
    }

    /// Reads a serialised state. The instance takes what can be read: goes on, is looked at, saved
    /// again, reset. Returns whether it could be read.
    pub fn read(&mut self, bytes: &[u8]) -> bool {
        let instance = &mut self.instance;
        let mut state = null_mut();
        if instance.deserialize(bytes, &mut state).is_err() {
            assert!(state.is_null(), "a refused state was kept");
            return false;
        }
        instance.restore(state).expect("what was read can be set");
        let again = instance
            .serialize(state)
            .expect("what was read can be written");
        self.live();
        let instance = &mut self.instance;
        // what it was is not lost
        instance.restore(state).expect("set twice");
        assert_eq!(instance.serialize(state).expect("written twice"), again);
        instance.forget(&mut state).expect("freed");
        instance.reset().expect("legal in every state");
        true
    }

    /// Leads the instance from wherever it is through a few steps. Each call is refused in most
    /// states; none may panic or hang.
    fn live(&mut self) {
        let experiment = Experiment {
            start_time: 0.0,
            stop_time: None,
            tolerance: None,
        };
        let _ = self.instance.setup_experiment(experiment);
        let _ = self.instance.enter_initialization_mode();
        self.look();
        let _ = self.instance.exit_initialization_mode();
        for h in [1e-9, 0.005, 1.0 / 60.0, 0.1] {
            let time = self.instance.last_successful_time().unwrap_or_default();
            let _ = self.instance.do_step(time, h);
            self.look();
        }
        serialized(&self.instance);
    }

    fn look(&mut self) {
        let instance = &mut self.instance;
        for reference in 0..self.variables {
            let _ = instance.get(&[reference], &mut [0.0]);
            let _ = instance.get(&[reference], &mut [0]);
            let _ = instance.get(&[reference], &mut [false]);
            let _ = instance.get(&[reference], &mut [String::new()]);
            let _ = instance.output_rates(&[reference], &[1], &mut [0.0]);
            let _ = instance.directional_derivative(&[reference], &[], &[], &mut [0.0]);
        }
    }
}

/// The present state in bytes.
fn serialized<M: Model>(instance: &Instance<M>) -> Vec<u8> {
    let mut state = null_mut();
    instance.save(&mut state).expect("legal in every state");
    let bytes = instance.serialize(state).expect("legal in every state");
    instance.forget(&mut state).expect("legal in every state");
    bytes
}

impl<M: Model> Default for Reader<M> {
    fn default() -> Self {
        Self::new()
    }
}

fmi_export::variables! {
    /// A model with variables of every type: a gauge that fills as Dahlquist's equation says.
    pub struct Gauge {
        rate: f64 = 1.0, Parameter Tunable, unit "1/s", in [0.0, 100.0], "Rate of decay";
        places: i32 = 3, Parameter Fixed, in [0, 9], "Decimal places shown";
        label: String = "level".to_owned(), Parameter Tunable, "What it shows";
        lit: bool = true, Input Discrete, "Whether it is lit";
        level: f64 = 1.0, Output Continuous, initial Exact, from [level], "Level";
        shown: String = String::new(), Output Discrete, "What can be read";
        time: f64 = 0.0, Independent Continuous, unit "s", "Time";
    }
}

impl Model for Gauge {
    fn description() -> ModelDescription {
        fmi_export::describe("Gauge", "A gauge", &Self::rows())
    }

    fn new() -> Self {
        Self::default()
    }

    fn get(&self, reference: u32) -> fmi_export::Value {
        self.value(reference)
    }

    fn set(&mut self, reference: u32, value: fmi_export::Value) {
        self.assign(reference, value);
    }

    fn initialize(&mut self, experiment: &Experiment) -> Result<(), String> {
        self.time = experiment.start_time;
        Ok(())
    }

    fn step(&mut self, t: f64, h: f64) -> Flow {
        self.level *= (-self.rate * h).exp();
        self.time = t + h;
        let places = self.places.clamp(0, 9) as usize;
        self.shown = format!("{} {:.places$}", self.label, self.level);
        Flow::Continue
    }
}
