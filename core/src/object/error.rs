//! What can be wrong with an object's file.

/// Why a file is not an object, or a scene cannot be seen.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ObjectError {
    /// The text is not the JSON that is expected.
    #[error("line {line}, column {column}: {message}")]
    Json { line: usize, column: usize, message: String },
    /// A number is outside its limits.
    #[error("object {object:?}, {place}: found {found}, wanted {wanted}")]
    Value { object: String, place: String, found: String, wanted: String },
    /// A scene names an object that does not exist.
    #[error("object {index} of the scene: {name:?} is none of the known objects")]
    Unknown { index: usize, name: String },
}
