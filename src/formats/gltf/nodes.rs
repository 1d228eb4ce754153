//! Where things stand: the nodes of a glTF file's scene, with their transforms in the world.

use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};

use super::schema::{Node, Root};
use super::surface::called;
use crate::formats::polygons::Fault;
use crate::scene::description::Transform;
use crate::scene::shapes::{MAX_LENGTH, MIN_LENGTH};

/// How far a matrix may be from one that scales, rotates and translates, as a share of its size: less than files tell.
const MOST_SHEAR: f64 = 1e-6;

/// A node of the scene.
#[derive(Debug, Clone, Copy)]
pub struct Placed {
    pub node: usize,
    /// World from node.
    pub world: DAffine3,
    /// Where the node above it stands among those placed, which is before it.
    pub parent: Option<usize>,
}

/// The nodes of the scene that is to be shown, parents before their children.
pub fn placed(root: &Root) -> Result<Vec<Placed>, Fault> {
    let nodes = &root.nodes;
    let name = |index: usize| called("node", index, &nodes[index].name);
    let roots: Vec<usize> = match (root.scene, root.scenes.first()) {
        (Some(scene), _) if !root.scenes.is_empty() => {
            let there = root.scenes.len();
            let found = root.scenes.get(scene);
            found.ok_or_else(|| Fault::new(format!("there is no scene {scene}: there are {there}")))?.nodes.clone()
        }
        (_, Some(first)) => first.nodes.clone(),
        (_, None) => {
            let mut is_child = vec![false; nodes.len()];
            let children = nodes.iter().flat_map(|node| &node.children);
            children.for_each(|&child| is_child.get_mut(child).into_iter().for_each(|child| *child = true));
            (0..nodes.len()).filter(|&index| !is_child[index]).collect()
        }
    };
    let mut is_placed = vec![false; nodes.len()];
    let mut placed: Vec<Placed> = Vec::new();
    let mut waiting: Vec<(usize, Option<usize>)> = roots.into_iter().rev().map(|index| (index, None)).collect();
    while let Some((index, parent)) = waiting.pop() {
        let there = nodes.len();
        let node =
            nodes.get(index).ok_or_else(|| Fault::new(format!("there is no node {index}: there are {there}")))?;
        if std::mem::replace(&mut is_placed[index], true) {
            let message = format!("{} is reached in two ways: each node has one parent at most", name(index));
            return Err(Fault::new(message));
        }
        let above = parent.map_or(DAffine3::IDENTITY, |parent| placed[parent].world);
        let world = above * local(node);
        let most = world.matrix3.to_cols_array().into_iter().chain(world.translation.to_array());
        if !most.into_iter().all(|number| number.abs() <= MAX_LENGTH) {
            return Err(Fault::new(format!("{} is too large or too far away", name(index))));
        }
        waiting.extend(node.children.iter().rev().map(|&child| (child, Some(placed.len()))));
        placed.push(Placed { node: index, world, parent });
    }
    Ok(placed)
}

/// Parent from node.
fn local(node: &Node) -> DAffine3 {
    if let Some(columns) = &node.matrix {
        return DAffine3::from_mat4(DMat4::from_cols_array(columns));
    }
    let rotation = node.rotation.map_or(DQuat::IDENTITY, |[x, y, z, w]| {
        // Without a direction there is nothing to turn to.
        let length = DVec3::new(x, y, z).length().hypot(w);
        if length > 0.0 && length.is_finite() {
            DQuat::from_xyzw(x / length, y / length, z / length, w / length)
        } else {
            DQuat::IDENTITY
        }
    });
    let (scale, translation) = (node.scale.unwrap_or([1.0; 3]), node.translation.unwrap_or_default());
    DAffine3::from_scale_rotation_translation(scale.into(), rotation, translation.into())
}

/// The same as scale, rotation and translation; `None` where it is something else, such as a shear, or flattens.
pub fn transform(world: &DAffine3) -> Option<Transform> {
    let columns = world.matrix3;
    let mut scale = DVec3::new(columns.x_axis.length(), columns.y_axis.length(), columns.z_axis.length());
    let (least, most) = (scale.min_element(), scale.max_element());
    if !(least > MIN_LENGTH && least > most * 1e-12) {
        return None;
    }
    let turned = DMat3::from_cols(columns.x_axis / scale.x, columns.y_axis / scale.y, columns.z_axis / scale.z);
    let mut rotation = turned;
    if turned.determinant() < 0.0 {
        scale.x = -scale.x;
        rotation.x_axis = -rotation.x_axis;
    }
    let transform = Transform { scale, rotate: angles(&rotation), translate: world.translation };
    let again = transform.matrix().matrix3;
    let differs = (again - columns).to_cols_array().into_iter().any(|number| number.abs() > MOST_SHEAR * most);
    (!differs).then_some(transform)
}

/// The angles about the fixed x, y and z axes, in this order, in degrees, of a rotation.
fn angles(rotation: &DMat3) -> DVec3 {
    let [x, y, z] = [rotation.x_axis, rotation.y_axis, rotation.z_axis];
    let across = x.x.hypot(x.y);
    let about_y = (-x.z).atan2(across);
    let (about_x, about_z) = match across {
        // The first axis is turned to the third: one of the other two angles is free.
        across if across < 1e-12 => (if x.z < 0.0 { y.x.atan2(y.y) } else { (-y.x).atan2(y.y) }, 0.0),
        _ => (y.z.atan2(z.z), x.y.atan2(x.x)),
    };
    // 0 rather than −0.
    DVec3::new(about_x.to_degrees(), about_y.to_degrees(), about_z.to_degrees()) + 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_transform_says_what_its_matrix_says() {
        let quarter = std::f64::consts::FRAC_PI_2;
        let turns = [-quarter, -0.3, 0.0, 0.7, quarter, 2.5];
        for index in 0..turns.len().pow(3) {
            let [x, y, z] = [index, index / turns.len(), index / turns.len().pow(2)].map(|i| turns[i % turns.len()]);
            for scale in
                [DVec3::ONE, DVec3::new(2.0, 0.1, 3.0), DVec3::new(-1.0, 2.0, 1.0), DVec3::new(-1.0, -1.0, -2.0)]
            {
                let rotation = DQuat::from_rotation_z(z) * DQuat::from_rotation_y(y) * DQuat::from_rotation_x(x);
                let world = DAffine3::from_scale_rotation_translation(scale, rotation, DVec3::new(1.0, 2.0, 3.0));
                let made = transform(&world).expect("it scales, turns and moves").matrix();
                let difference = (made.matrix3 - world.matrix3).to_cols_array();
                assert!(difference.iter().all(|d| d.abs() < 1e-11), "{x} {y} {z} {scale}: {difference:?}");
                assert_eq!(made.translation, world.translation);
            }
        }
        assert_eq!(transform(&DAffine3::IDENTITY), Some(Transform::IDENTITY));
    }

    #[test]
    fn shear_and_flatness_have_no_transform() {
        let turned = DAffine3::from_rotation_z(0.5);
        let sheared = DAffine3::from_scale(DVec3::new(1.0, 2.0, 1.0)) * turned;
        assert_eq!(transform(&sheared), None);
        assert!(transform(&(turned * DAffine3::from_scale(DVec3::new(1.0, 2.0, 1.0)))).is_some());
        assert_eq!(transform(&DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0))), None);
    }

    #[test]
    fn nodes_form_trees() {
        let root = |text: &str| serde_json::from_str::<Root>(text).unwrap();
        let chain = root(
            r#"{"scenes":[{"nodes":[2]}],"nodes":[{"translation":[1,0,0]},{"children":[0],"scale":[2,2,2]},{"children":[1]}]}"#,
        );
        let nodes = placed(&chain).unwrap();
        assert_eq!(
            nodes.iter().map(|p| (p.node, p.parent)).collect::<Vec<_>>(),
            [(2, None), (1, Some(0)), (0, Some(1))]
        );
        assert_eq!(nodes[2].world.translation, DVec3::X * 2.0);
        // Without scenes, all that is below nothing.
        assert_eq!(placed(&root(r#"{"nodes":[{},{"children":[0]}]}"#)).unwrap()[0].node, 1);
        for (text, why) in [
            (r#"{"scenes":[{"nodes":[0]}],"nodes":[{"children":[0]}]}"#, "node 0 is reached in two ways"),
            (r#"{"scenes":[{"nodes":[0,1]}],"nodes":[{"name":"a","children":[1]},{"name":"b"}]}"#, "node 1 (`b`)"),
            (r#"{"scenes":[{"nodes":[7]}],"nodes":[{}]}"#, "there is no node 7"),
            (r#"{"scene":3,"scenes":[{"nodes":[0]}],"nodes":[{}]}"#, "there is no scene 3"),
            (r#"{"nodes":[{"scale":[1e300,1,1]}]}"#, "too large"),
        ] {
            let message = placed(&root(text)).unwrap_err().message;
            assert!(message.contains(why), "{message}");
        }
    }
}
