//! Pictures on disk: PNG for the eye, EXR for numbers, labelled comparisons. Every file is written beside and renamed.
