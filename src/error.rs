//! The one error type: a plain sentence for the person at the keyboard, and the exit status that goes with it.

/// What went wrong, worded so that it says what to do next.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Error {
    /// Bad usage or bad input: exit status 2.
    #[error("{0}")]
    Input(String),
    /// Anything else (device, disk, driver): exit status 1.
    #[error("{0}")]
    Runtime(String),
}

impl Error {
    /// An error in what the user gave.
    pub fn input(sentence: impl Into<String>) -> Self {
        Self::Input(sentence.into())
    }

    /// An error of the machine, the device or the disk.
    pub fn runtime(sentence: impl Into<String>) -> Self {
        Self::Runtime(sentence.into())
    }

    /// The process exit status for this error.
    pub fn exit_status(&self) -> u8 {
        match self {
            Self::Input(_) => 2,
            Self::Runtime(_) => 1,
        }
    }
}

/// Result with [`Error`].
pub type Result<T> = std::result::Result<T, Error>;
