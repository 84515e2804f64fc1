//! What a shared library is, read from its bytes without loading it.

use crate::Function;
use crate::error::shortened;
use model_description::Platform;
use object::read::elf::{ElfFile, FileHeader};
use object::read::macho::{FatArch, MachOFatFile32, MachOFatFile64};
use object::read::{Error, NameOrOrdinal, Result};
use object::{Architecture, BinaryFormat, File, FileKind, Object, ObjectKind, elf};
use std::fmt;

/// Facts of a shared library.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Library {
    /// The platform it is for.
    pub platform: Platform,
    /// Names of the symbols it exports, sorted.
    pub exports: Vec<String>,
    /// The libraries it needs, in its order.
    pub needs: Vec<String>,
    /// The oldest glibc it runs with; `None` where it needs none.
    pub glibc: Option<Glibc>,
}

/// A version of the GNU C library.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Glibc {
    /// Before the point.
    pub major: u32,
    /// After it.
    pub minor: u32,
}

impl fmt::Display for Glibc {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}.{}", self.major, self.minor)
    }
}

/// What may keep an FMU from running elsewhere, though it is no error.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Warning {
    /// Symbols that are none of FMI 2.0: two FMUs in one process may get each other's.
    Exports(Vec<String>),
    /// Libraries that the system does not have of itself.
    Needs(Vec<String>),
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Exports(names) => {
                write!(
                    f,
                    "expected FMI 2.0 functions only, exports {}",
                    shortened(names)
                )
            }
            Self::Needs(names) => {
                write!(
                    f,
                    "expected libraries of the system only, needs {}",
                    shortened(names)
                )
            }
        }
    }
}

/// The functions a library for co-simulation exports: those of the life cycle, and the three that
/// are called without an instance (FMI 2.0 §2.1).
fn functions() -> impl Iterator<Item = &'static str> {
    ["fmi2GetTypesPlatform", "fmi2GetVersion", "fmi2Instantiate"]
        .into_iter()
        .chain(Function::ALL.iter().map(|function| function.name))
}

impl Library {
    /// The facts of the library that consists of `bytes`; else what `bytes` are, in words.
    pub(crate) fn read(bytes: &[u8]) -> std::result::Result<Self, String> {
        let words = |error: Error| format!("other bytes ({error})");
        let bytes = slice(bytes).map_err(words)?;
        let kind = FileKind::parse(bytes).map_err(words)?;
        if matches!(kind, FileKind::Archive) {
            return Err("a static library".to_owned());
        }
        let file = File::parse(bytes).map_err(words)?;
        if file.kind() != ObjectKind::Dynamic {
            return Err(format!("a file of kind {:?}", file.kind()));
        }
        let platform = platform(&file)
            .ok_or_else(|| format!("{:?} for {:?}", file.format(), file.architecture()))?;
        let mut exports = exports(&file).map_err(words)?;
        exports.sort();
        exports.dedup();
        Ok(Self {
            platform,
            exports,
            needs: needs(&file).map_err(words)?,
            glibc: match &file {
                File::Elf32(file) => glibc(file),
                File::Elf64(file) => glibc(file),
                _ => Ok(None),
            }
            .map_err(words)?,
        })
    }

    /// The functions of FMI 2.0 for co-simulation that it lacks.
    pub fn missing(&self) -> Vec<&'static str> {
        let lacks = |name: &&str| {
            let found = self
                .exports
                .binary_search_by(|export| export.as_str().cmp(name));
            found.is_err()
        };
        functions().filter(lacks).collect()
    }

    /// What may keep it from running elsewhere.
    pub fn warnings(&self) -> Vec<Warning> {
        let others = |names: &[String], known: &dyn Fn(&str) -> bool| -> Vec<String> {
            names.iter().filter(|name| !known(name)).cloned().collect()
        };
        // A library may offer model exchange besides.
        let exports = others(&self.exports, &|name| name.starts_with("fmi2"));
        let needs = others(&self.needs, &|name| is_of_the_system(self.platform, name));
        let mut warnings = Vec::new();
        if !exports.is_empty() {
            warnings.push(Warning::Exports(exports));
        }
        if !needs.is_empty() {
            warnings.push(Warning::Needs(needs));
        }
        warnings
    }
}

/// The bytes of a library; of a universal one those for x86-64, else the first.
fn slice(bytes: &[u8]) -> Result<&[u8]> {
    fn pick<'a, Fat: FatArch>(bytes: &'a [u8], slices: &[Fat]) -> Result<&'a [u8]> {
        let intel = |slice: &&Fat| slice.architecture() == Architecture::X86_64;
        let slice = slices.iter().find(intel).or(slices.first());
        slice.map_or(Ok(bytes), |slice| slice.data(bytes))
    }
    match FileKind::parse(bytes)? {
        FileKind::MachOFat32 => pick(bytes, MachOFatFile32::parse(bytes)?.arches()),
        FileKind::MachOFat64 => pick(bytes, MachOFatFile64::parse(bytes)?.arches()),
        _ => Ok(bytes),
    }
}

/// FMI 2.0 names operating systems and word lengths and, but for macOS, means x86.
fn platform(file: &File) -> Option<Platform> {
    Some(match (file.format(), file.architecture()) {
        (BinaryFormat::Elf, Architecture::X86_64) => Platform::Linux64,
        (BinaryFormat::Elf, Architecture::I386) => Platform::Linux32,
        (BinaryFormat::Pe, Architecture::X86_64) => Platform::Win64,
        (BinaryFormat::Pe, Architecture::I386) => Platform::Win32,
        (BinaryFormat::MachO, Architecture::X86_64 | Architecture::Aarch64) => Platform::Darwin64,
        (BinaryFormat::MachO, Architecture::I386) => Platform::Darwin32,
        _ => return None,
    })
}

fn exports(file: &File) -> Result<Vec<String>> {
    // Apple's linker puts an underscore before the names of C.
    let prefix = match file.format() {
        BinaryFormat::MachO => "_",
        _ => "",
    };
    file.exports()?
        .map(|export| {
            Ok(match export?.into_name() {
                NameOrOrdinal::Name(name) => {
                    let name = String::from_utf8_lossy(&name).into_owned();
                    name.strip_prefix(prefix).unwrap_or(&name).to_owned()
                }
                NameOrOrdinal::Ordinal(number) => format!("#{number}"),
            })
        })
        .collect()
}

fn needs(file: &File) -> Result<Vec<String>> {
    file.import_libraries()?
        .map(|library| Ok(String::from_utf8_lossy(library?.name()).into_owned()))
        .collect()
}

/// The newest version of glibc that the loader will ask for: the file lists them, and only those
/// marked weak may be absent.
fn glibc<Elf: FileHeader>(file: &ElfFile<Elf>) -> Result<Option<Glibc>> {
    let (endian, data) = (file.endian(), file.data());
    let sections = file.elf_section_table();
    let Some((mut libraries, strings)) = sections.gnu_verneed(endian, data)? else {
        return Ok(None);
    };
    let strings = sections.strings(endian, data, strings)?;
    let mut floor = None;
    while let Some((_, mut versions)) = libraries.next()? {
        while let Some(version) = versions.next()? {
            if !version.vna_flags.get(endian).contains(elf::VER_FLG_WEAK) {
                floor = floor.max(version_of(version.name(endian, strings)?));
            }
        }
    }
    Ok(floor)
}

/// `GLIBC_2.34` as numbers.
fn version_of(name: &[u8]) -> Option<Glibc> {
    let version = str::from_utf8(name).ok()?.strip_prefix("GLIBC_")?;
    // Not a number, but a promise that 2.36 was the first to make.
    if version == "ABI_DT_RELR" {
        return Some(Glibc {
            major: 2,
            minor: 36,
        });
    }
    let mut numbers = version.split('.').map(str::parse);
    match (numbers.next(), numbers.next()) {
        (Some(Ok(major)), Some(Ok(minor))) => Some(Glibc { major, minor }),
        _ => None,
    }
}

/// Whether every system of this kind has the library.
fn is_of_the_system(platform: Platform, library: &str) -> bool {
    match platform {
        Platform::Linux32 | Platform::Linux64 => [
            "libc.so.6",
            "libm.so.6",
            "libgcc_s.so.1",
            "ld-linux-x86-64.so.2",
            "ld-linux.so.2",
            // part of libc since glibc 2.34
            "libpthread.so.0",
            "libdl.so.2",
        ]
        .contains(&library),
        Platform::Win32 | Platform::Win64 => {
            let name = library.to_ascii_lowercase();
            let system = [
                "advapi32.dll",
                "bcrypt.dll",
                "bcryptprimitives.dll",
                "kernel32.dll",
                "msvcrt.dll",
                "ntdll.dll",
                "ole32.dll",
                "shell32.dll",
                "ucrtbase.dll",
                "user32.dll",
                "userenv.dll",
                "ws2_32.dll",
            ];
            name.starts_with("api-ms-win-") || system.contains(&name.as_str())
        }
        Platform::Darwin32 | Platform::Darwin64 => {
            library.starts_with("/usr/lib/") || library.starts_with("/System/Library/")
        }
    }
}
