//! The library, asked through what it offers others. One binary, so that the tests are linked once and share what they compute.

mod common;
#[path = "../tev_listener.rs"]
mod tev_listener;

mod advice;
mod agreement;
mod bad_input;
mod both_ends;
mod camera;
mod closed_forms;
mod crowds;
mod declared;
mod edits;
mod environment_files;
mod example;
mod experiment;
mod export;
mod extremes;
mod families;
mod geometry;
#[cfg(feature = "gpu")]
mod gpu;
mod kept;
mod layering;
mod lights;
mod loaders;
mod measure;
mod moved_scenes;
mod optics;
mod other_renderers;
mod priority;
mod properties;
mod random_meshes;
mod readme;
mod rectification;
mod reference;
mod report;
mod resolved;
mod seams;
mod skies;
mod smooth_normals;
mod stability;
mod tev;
mod texture_formats;
mod textures;
mod topology;
mod transport;
mod variance;
