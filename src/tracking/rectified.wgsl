// Twin of `rectified.rs`: the media are looked up in what rectification stored. All of it is in `rectify/flat.wgsl`.
