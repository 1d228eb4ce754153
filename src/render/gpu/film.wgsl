// Adds samples to the sums of pixels.

/// What the samples of a pixel come to.
struct PixelSums {
    radiance: vec3f,
    /// Samples in the sum: those that are finite.
    count: u32,
    squares: vec3f,
    segments: u32,
}

@group(1) @binding(0) var<storage, read_write> sums: array<PixelSums>;
/// In the order of `Events`.
@group(1) @binding(1) var<storage, read_write> event_counts: array<atomic<u32>, 6>;
/// The first sample of each pixel and the one after the last, where they differ.
@group(1) @binding(2) var<storage, read> ranges: array<vec2u>;

@compute @workgroup_size(8, 8)
fn render(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= image.width || id.y >= image.row_count {
        return;
    }
    let column = id.x;
    let row = image.first_row + id.y;
    let pixel = row * image.width + column;
    let place = id.y * image.width + column;
    var range = vec2u(image.first_sample, image.last_sample);
    if image.has_ranges != 0u {
        range = ranges[pixel];
    }
    let first = range.x + image.samples_before;
    let last = min(first + image.sample_count, range.y);
    var sum = PixelSums(vec3f(0.0), 0u, vec3f(0.0), 0u);
    for (var sample = first; sample < last; sample += 1u) {
        let sampler_ = sampler_of(image.seed_hash, pixel, sample);
        var lens = vec2f(0.0);
        if image.aperture_radius != 0.0 {
            lens = lens_point(get_2d(sampler_, LENS));
        }
        let ray = camera_ray(vec2u(column, row), get_2d(sampler_, PIXEL), lens);
        let traced = trace_path(ray, image.start_medium, sampler_);
        sum.segments += traced.segments;
        if is_finite(traced.radiance) {
            sum.radiance += traced.radiance;
            sum.squares += traced.radiance * traced.radiance;
            sum.count += 1u;
        } else {
            events.non_finite += 1u;
        }
    }
    sums[place] = sum;
    count_events(0u, events.stack_underflow);
    count_events(1u, events.stack_overflow);
    count_events(2u, events.inconsistent);
    count_events(3u, events.non_finite);
    count_events(4u, events.crossings);
    count_events(5u, events.mixed);
}

fn count_events(kind: u32, count: u32) {
    if count != 0u {
        atomicAdd(&event_counts[kind], count);
    }
}
