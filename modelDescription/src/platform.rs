//! Where the binaries of a platform lie in the archive (FMI 2.0 §2.3).

use std::fmt;

/// A platform the standard names.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Platform {
    /// 32-bit Linux.
    Linux32,
    /// 64-bit Linux.
    Linux64,
    /// 32-bit Windows.
    Win32,
    /// 64-bit Windows.
    Win64,
    /// 32-bit macOS.
    Darwin32,
    /// 64-bit macOS.
    Darwin64,
}

impl Platform {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Linux32,
        Self::Linux64,
        Self::Win32,
        Self::Win64,
        Self::Darwin32,
        Self::Darwin64,
    ];

    /// The platform this program was compiled for, if the standard names it. It names operating
    /// systems and word lengths and, but for macOS, means x86.
    pub const fn current() -> Option<Self> {
        if cfg!(not(any(target_arch = "x86", target_arch = "x86_64"))) && !cfg!(target_os = "macos")
        {
            return None;
        }
        match (
            cfg!(target_os = "linux"),
            cfg!(target_os = "windows"),
            cfg!(target_os = "macos"),
            cfg!(target_pointer_width = "64"),
        ) {
            (true, _, _, true) => Some(Self::Linux64),
            (true, _, _, false) => Some(Self::Linux32),
            (_, true, _, true) => Some(Self::Win64),
            (_, true, _, false) => Some(Self::Win32),
            (_, _, true, true) => Some(Self::Darwin64),
            (_, _, true, false) => Some(Self::Darwin32),
            _ => None,
        }
    }

    /// The folder below `binaries`.
    pub const fn folder(self) -> &'static str {
        match self {
            Self::Linux32 => "linux32",
            Self::Linux64 => "linux64",
            Self::Win32 => "win32",
            Self::Win64 => "win64",
            Self::Darwin32 => "darwin32",
            Self::Darwin64 => "darwin64",
        }
    }

    /// The suffix of a shared library, with its dot.
    pub const fn suffix(self) -> &'static str {
        match self {
            Self::Linux32 | Self::Linux64 => ".so",
            Self::Win32 | Self::Win64 => ".dll",
            Self::Darwin32 | Self::Darwin64 => ".dylib",
        }
    }

    /// The path of a model's library in the archive: `binaries/linux64/Model.so`.
    pub fn library(self, model_identifier: &str) -> String {
        format!(
            "binaries/{}/{model_identifier}{}",
            self.folder(),
            self.suffix()
        )
    }
}

impl fmt::Display for Platform {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.folder())
    }
}
