//! Why a link or a session is not taken.

use endcomfort_core::scene::SceneError;

/// Why a link or a session is not taken; each variant is a clause for a sentence.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ShareError {
    /// Characters that do not belong there, or too few of them.
    #[error("it is not base64url ({reason})")]
    Base64 { reason: String },
    /// Bytes that no packer wrote.
    #[error("what it holds is not deflate-compressed, or it was cut off")]
    Deflate,
    /// A small link that unpacks to something huge.
    #[error("what it holds unpacks to more than {limit} bytes")]
    TooLarge { limit: usize },
    /// Not JSON, or not our fields.
    #[error("what it holds is not ours ({reason})")]
    Format { reason: String },
    /// Written by another version of the program.
    #[error("its version is {found}, and this program reads version {wanted}")]
    Version { found: String, wanted: u32 },
    /// A demo that this program does not have.
    #[error("it names the demo {name:?}, and the demos are {}", known.join(", "))]
    Demo { name: String, known: Vec<String> },
    /// Neither a demo nor a scene.
    #[error("it names no demo and holds no scene")]
    Nothing,
    /// Its scene.
    #[error("its scene is wrong: {0}")]
    Scene(#[from] SceneError),
    /// A number outside its range.
    #[error("{place}: found {found}, wanted {wanted}")]
    Value { place: String, found: String, wanted: String },
}
