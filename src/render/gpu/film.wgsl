// Adds samples to the sums of pixels: each thread takes those of one pixel, one after the other.
//
// A thread that has taken very many steps puts its path away, and the next dispatch goes on with it. So no dispatch takes long because of
// a few paths that are caught between mirrors. (Mesa's llvmpipe needs it: it ends all loops of a thread that have taken 65,535 turns together.)

/// What the samples of a pixel come to.
struct PixelSums {
    radiance: vec3f,
    /// Samples in the sum: those that are finite.
    count: u32,
    squares: vec3f,
    segments: u32,
}

@group(1) @binding(0) var<storage, read_write> sums: array<PixelSums>;
/// In the order of `Events`, then the threads that are not at their end.
@group(1) @binding(1) var<storage, read_write> event_counts: array<atomic<u32>, 7>;
/// The first sample of each pixel and the one after the last, where they differ.
@group(1) @binding(2) var<storage, read> ranges: array<vec2u>;
/// Paths that go on in the next dispatch, by the place of their pixel in the part, and what trackers keep of them.
@group(1) @binding(3) var<storage, read_write> paths: array<Path>;
@group(1) @binding(4) var<storage, read_write> tracker_states: array<u32>;

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
    let last = min(range.x + image.samples_before + image.sample_count, range.y);
    var sum = PixelSums(vec3f(0.0), 0u, vec3f(0.0), 0u);
    var path: Path;
    path.sample = range.x + image.samples_before;
    if image.is_start == 0u {
        path = paths[place];
        if path.sample == NOTHING {
            return;
        }
        sum = sums[place];
        tracker_load(TRACKER_WORDS * place);
    }
    var is_interrupted = false;
    while path.sample < last {
        if steps >= image.most_steps {
            is_interrupted = true;
            break;
        }
        let sampler_ = sampler_of(image.seed_hash, pixel, path.sample);
        if path.segment == 0u {
            var lens = vec2f(0.0);
            if image.aperture_radius != 0.0 {
                lens = lens_point(get_2d(sampler_, LENS));
            }
            let ray = camera_ray(vec2u(column, row), get_2d(sampler_, PIXEL), lens);
            path = path_along(ray, image.start_medium, path.sample);
        }
        if !follow(&path, sampler_, image.most_steps) {
            is_interrupted = true;
            break;
        }
        sum.segments += path.segment;
        if is_finite(path.radiance) {
            sum.radiance += path.radiance;
            sum.squares += path.radiance * path.radiance;
            sum.count += 1u;
        } else {
            events.non_finite += 1u;
        }
        path.sample += 1u;
        path.segment = 0u;
    }
    if is_interrupted {
        paths[place] = path;
        tracker_save(TRACKER_WORDS * place);
        count_events(6u, 1u);
    } else {
        paths[place].sample = NOTHING;
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
