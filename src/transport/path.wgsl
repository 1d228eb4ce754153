// Twin of `path.rs`, without splitting: one sample of a pixel.
//
// Rays are sent for different reasons: along the path, from a vertex to a light, past an edge, for the members of a cell. There is one loop, in which
// each turn sends one ray, whatever for: so paths of a group that are in different states still go through the tree together, a hit is
// found again at the same distance to the bit, and the tree walk is compiled once.

const ROULETTE_FROM: u32 = 4u;
const ROULETTE_SHARE: f32 = 0.25;
const LONG_PATH: u32 = 64u;

/// What a ray is sent for: to go on from where the walker is; to see whether the hit at an edge is undone by one behind it; to learn whether a point is
/// in the member of a cell.
const TO_WALK: u32 = 0u;
const TO_SEE_BEHIND_EDGE: u32 = 1u;
const TO_FIND_MEMBER: u32 = 2u;

/// A path on its way. It is what memory holds of a path that goes on in the next dispatch.
struct Path {
    origin: vec3f,
    /// Number of the sample.
    sample: u32,
    direction: vec3f,
    leaves: u32,
    /// Throughput, without the product of (n_from/n_to)², which is `radiance_scale`.
    beta: vec3f,
    t_min: f32,
    radiance: vec3f,
    after: u32,
    /// Where the path last scattered by a density that light sampling competes with.
    last_position: vec3f,
    /// 0: it did not.
    last_pdf: f32,
    medium: u32,
    /// 0: it has not been started.
    segment: u32,
    radiance_scale: f32,
    roulette_below: f32,
    has_scattered: u32,
    pad0: u32,
    pad1: u32,
    pad2: u32,
}

/// A path along a ray that starts in `medium`.
fn path_along(ray: Ray, medium: u32, sample: u32) -> Path {
    var path: Path;
    path.origin = ray.origin;
    path.sample = sample;
    path.direction = ray.direction;
    path.leaves = ray.leaves;
    path.beta = vec3f(1.0);
    path.t_min = ray.t_min;
    path.after = ray.after;
    path.medium = medium;
    path.segment = 1u;
    path.radiance_scale = 1.0;
    path.roulette_below = ROULETTE_SHARE;
    tracker_start(PATH);
    return path;
}

fn survival_of_long_path(segment: u32) -> f32 {
    return min(1.0 - 1.0 / (f32(segment - LONG_PATH) + 19.0), 0.9999);
}

/// Follows a path to its end, or until this thread has taken `most_steps`. Returns whether it is at its end.
fn follow(path: ptr<function, Path>, sampler_: Sampler, most_steps: u32) -> bool {
    var radiance = (*path).radiance;
    var segment = (*path).segment;
    var beta = (*path).beta;
    var radiance_scale = (*path).radiance_scale;
    var roulette_below = (*path).roulette_below;
    var has_scattered = (*path).has_scattered != 0u;
    var last_pdf = (*path).last_pdf;
    var last_position = (*path).last_position;

    // The walker: the path, or a shadow ray of its vertex, after which the path goes on along `onward`.
    var walker = PATH;
    var ray = Ray((*path).origin, (*path).direction, (*path).leaves, (*path).t_min, (*path).after);
    var medium = (*path).medium;
    var vertex: Vertex;
    var light = ASKED_ALL;
    var shadow: ShadowRay;
    var onward = vec3f(0.0);
    var path_medium = medium;

    var purpose = TO_WALK;
    // The hit that the tracker is asked about; whether it is the one behind `edge`, at which `edge_sides` were told.
    var hit: Hit;
    var is_behind_edge = false;
    var edge: Hit;
    var edge_sides: Sides;

    loop {
        if steps >= most_steps && walker == PATH && purpose == TO_WALK {
            *path = Path(
                ray.origin,
                (*path).sample,
                ray.direction,
                ray.leaves,
                beta,
                ray.t_min,
                radiance,
                ray.after,
                last_position,
                last_pdf,
                medium,
                segment,
                radiance_scale,
                roulette_below,
                u32(has_scattered),
                0u,
                0u,
                0u,
            );
            return false;
        }
        var sent = ray;
        var reach = FAR;
        var only_object = NOTHING;
        var is_any = false;
        if purpose == TO_SEE_BEHIND_EDGE {
            sent = ray_beyond(ray, edge);
            reach = edge.t + same_place(ray, edge);
        } else if purpose == TO_FIND_MEMBER {
            sent = member_ray(crossing_of(ray, hit));
            only_object = member_object();
        } else if walker == SHADOW {
            reach = shadow.sample.distance;
            is_any = !CAN_PASS && shadow.sample.object == NOTHING;
        }
        let found = search(sent, reach, only_object, is_any);

        // Whether the walk of a shadow ray is over.
        var is_over = false;
        var is_settled = false;
        var is_known = true;
        if purpose == TO_FIND_MEMBER {
            tracker_hear(found.primitive != NOTHING && !found.is_front);
            is_known = tracker_go_on(crossing_of(ray, hit));
        } else if purpose == TO_SEE_BEHIND_EDGE {
            is_behind_edge = found.primitive != NOTHING && objects[faces[found.primitive].object].kind == REFRACTOR;
            if is_behind_edge {
                hit = found;
                is_known = tracker_ask(walker, crossing_of(ray, hit), false);
            } else {
                hit = edge;
                told = edge_sides;
                is_settled = true;
            }
        } else {
            let passed = transmittance(medium, ray, found.t);
            if walker == PATH {
                beta *= passed;
            } else {
                shadow.radiance *= passed;
            }
            if found.primitive == NOTHING {
                if walker == PATH {
                    var weight = 1.0;
                    if last_pdf > 0.0 {
                        weight = power_heuristic(last_pdf, environment_density_of(ray.direction));
                    }
                    radiance += beta * environment_radiance(ray.direction) * (radiance_scale * weight);
                    if SUNS {
                        radiance += beta * suns_radiance(ray.direction, last_pdf) * radiance_scale;
                    }
                    break;
                }
                if shadow.sample.object == NOTHING {
                    radiance += shadow.radiance;
                }
                is_over = true;
            } else {
                hit = found;
                let object = faces[hit.primitive].object;
                let kind = objects[object].kind;
                if walker == SHADOW && (object == shadow.sample.object || !CAN_PASS || kind != REFRACTOR) {
                    if object == shadow.sample.object
                        && hit.primitive == shadow.sample.primitive
                        && emits(object, hit.is_front) {
                        radiance += shadow.radiance;
                    }
                    is_over = true;
                } else if kind == REFRACTOR {
                    events.crossings += u32(walker == PATH);
                    is_known = tracker_ask(walker, crossing_of(ray, hit), walker == PATH);
                } else if kind == LIGHT {
                    if emits(object, hit.is_front) {
                        var weight = 1.0;
                        if last_pdf > 0.0 {
                            let point = surface_at(ray, hit);
                            weight =
                                power_heuristic(last_pdf, emitter_density_of(last_position, ray.direction, object, point));
                        }
                        radiance += beta * objects[object].color * (radiance_scale * weight);
                    }
                    break;
                }
            }
        }
        if !is_known {
            purpose = TO_FIND_MEMBER;
            continue;
        }

        if !is_over {
            let object = faces[hit.primitive].object;
            var is_refractor = objects[object].kind == REFRACTOR;
            var crossing: Crossing;
            var optics: Interface;
            if is_refractor {
                purpose = TO_WALK;
                if is_behind_edge {
                    is_behind_edge = false;
                    if told.is_interface && told.before == medium && told.behind == edge_sides.before {
                        // The two hits cancel each other.
                        ray = ray_beyond(ray, hit);
                        continue;
                    }
                    hit = edge;
                    told = edge_sides;
                    is_settled = true;
                }
                crossing = crossing_of(ray, hit);
                if told.is_interface && !is_consistent(medium, told.before) {
                    if !is_settled {
                        if has_just_met(ray, hit) {
                            ray = ray_beyond(ray, hit);
                            continue;
                        }
                        if told.behind == medium {
                            edge = hit;
                            edge_sides = told;
                            purpose = TO_SEE_BEHIND_EDGE;
                            continue;
                        }
                    }
                    events.inconsistent += u32(walker == PATH);
                }
                if told.is_interface {
                    optics = interface_between(told.before, told.behind);
                }
                if !told.is_interface || optics.e == 0.0 {
                    // The same ray goes on; neither depth nor random numbers are used up.
                    tracker_transmit(walker, crossing);
                    medium = select(medium, told.behind, told.is_interface);
                    ray = ray_beyond(ray, hit);
                    continue;
                }
                is_over = walker == SHADOW;
            }

            if walker == PATH {
                if segment >= image.max_depth {
                    break;
                }
                let dimensions = dimensions_of_segment(segment);
                segment += 1u;
                if segment > ROULETTE_FROM {
                    var survival = min(max_component(beta) / roulette_below, 1.0);
                    if segment > LONG_PATH {
                        survival = min(survival, survival_of_long_path(segment));
                    }
                    if survival < 1.0 {
                        if get_1d(sampler_, dimensions + ROULETTE) >= survival {
                            break;
                        }
                        beta /= survival;
                    }
                }
                if is_refractor {
                    let normals = normals_at(hit, crossing.normal);
                    let u = get_1d(sampler_, dimensions + SCATTER);
                    let scattered = dielectric_scatter(optics, ray.direction, normals, segment - 1u, u);
                    last_pdf = 0.0;
                    if scattered.is_transmitted {
                        radiance_scale *= optics.radiance_factor;
                        tracker_transmit(PATH, crossing);
                        medium = told.behind;
                    }
                    ray = ray_leaving(crossing.position, scattered.direction, hit.primitive);
                    continue;
                }
                let point = surface_at(ray, hit);
                let normals = normals_at(hit, point.normal);
                let albedo = albedo_at(object, hit, point);
                if objects[object].kind == MIRROR {
                    last_pdf = 0.0;
                    beta *= albedo;
                    ray = ray_leaving(point.position, mirror_reflect(ray.direction, normals), hit.primitive);
                    continue;
                }
                if all(albedo == vec3f(0.0)) {
                    break;
                }
                let sampled = lambert_sample(normals, get_2d(sampler_, dimensions + DIRECTION));
                vertex = Vertex(point.position, hit.primitive, normals, beta * albedo * radiance_scale, dimensions);
                last_pdf = sampled.pdf;
                last_position = point.position;
                beta *= albedo;
                if !has_scattered {
                    roulette_below = ROULETTE_SHARE * max_component(beta);
                    has_scattered = true;
                }
                onward = sampled.direction;
                path_medium = medium;
                light = ASK_ENVIRONMENT;
                is_over = true;
            }
        }

        // At a vertex: to the next light that is to be asked, then on.
        if is_over {
            walker = PATH;
            while light < ASKED_ALL && walker == PATH {
                shadow = shadow_ray(vertex, sampler_, light);
                light += 1u;
                if shadow.sample.pdf > 0.0 {
                    walker = SHADOW;
                }
            }
            medium = path_medium;
            purpose = TO_WALK;
            if walker == SHADOW {
                tracker_copy();
                ray = ray_leaving(vertex.position, shadow.sample.direction, vertex.primitive);
            } else {
                ray = ray_leaving(vertex.position, onward, vertex.primitive);
            }
        }
    }
    (*path).radiance = radiance;
    (*path).segment = segment;
    return true;
}
