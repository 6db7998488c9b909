//! The browser entry points: page and worker.
