// Adds samples to the sums of pixels: each thread takes those of one pixel, one after the other.
//
// A thread that has taken so many steps puts its path away, and a later dispatch goes on with those that are left, side by side again. So no
// dispatch takes longer than is wanted, whatever paths do, such as those that are caught between mirrors: see `pace.rs`.

/// What the samples of a pixel come to.
struct PixelSums {
    radiance: vec3f,
    /// Samples in the sum: those that are finite.
    count: u32,
    squares: vec3f,
    segments: u32,
}

@group(1) @binding(0) var<storage, read_write> sums: array<PixelSums>;
/// In the order of `Events`, then the threads that are not at their end, then steps in units of 64.
@group(1) @binding(1) var<storage, read_write> event_counts: array<atomic<u32>, 8>;
/// The first sample of each pixel and the one after the last, where they differ.
@group(1) @binding(2) var<storage, read> ranges: array<vec2u>;
/// Paths that go on in a later dispatch, by the place of their pixel in the band, and what trackers keep of them.
@group(1) @binding(3) var<storage, read_write> paths: array<Path>;
@group(1) @binding(4) var<storage, read_write> tracker_states: array<u32>;
/// Places of those paths: what this dispatch goes on with, and elsewhere what it leaves to the next.
@group(1) @binding(5) var<storage, read_write> lists: array<u32>;

@compute @workgroup_size(8, 8)
fn render(
    @builtin(global_invocation_id) id: vec3u,
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_index) thread: u32,
) {
    var place = image.first_place + id.y * image.width + id.x;
    if image.is_start != 0u {
        if id.x >= image.width || id.y >= image.row_count {
            return;
        }
    } else {
        let entry = 64u * group.x + thread;
        if entry >= image.path_count {
            return;
        }
        place = lists[image.list_in + entry];
    }
    let column = place % image.width;
    let row = image.first_row + place / image.width;
    let pixel = row * image.width + column;
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
        lists[image.list_out + atomicAdd(&event_counts[6], 1u)] = place;
    }
    sums[place] = sum;
    count_events(0u, events.stack_underflow);
    count_events(1u, events.stack_overflow);
    count_events(2u, events.inconsistent);
    count_events(3u, events.non_finite);
    count_events(4u, events.crossings);
    count_events(5u, events.mixed);
    count_events(7u, (steps + 32u) / 64u);
}

fn count_events(kind: u32, count: u32) {
    if count != 0u {
        atomicAdd(&event_counts[kind], count);
    }
}
