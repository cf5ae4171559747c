//! What changes from frame to frame while the light moves by a third of a texel.

use super::lights;
use super::room::Room;
use crate::Vector3;
use crate::shade::Emitter;
use crate::vsgl::Vsgl;

/// The root mean square over pixels of the change of the error between frames, over the mean, and the median of its absolute
/// value.
fn flicker(room: &mut Room, emitter: Emitter, of: &dyn Fn(&Room) -> Vec<Vsgl>) -> (f64, f64) {
    let start = room.light.position;
    // A texel of the map at the floor, below the light.
    let step = 2.0 * 1.4 * 1.9 / room.size[0] as f64 / 3.0;
    let frames: Vec<(Vec<f64>, f64)> = (0..4)
        .map(|frame| {
            room.lit_from(start + Vector3::new(0.8, 0.0, 0.6) * (step * f64::from(frame)));
            let reference = room.reference();
            let picture = room.picture(&of(room), emitter);
            let mean = reference.iter().map(|pixel| pixel[1]).sum::<f64>() / reference.len() as f64;
            let error = picture.iter().zip(&reference).map(|(a, b)| a[1] - b[1]).collect();
            (error, mean)
        })
        .collect();
    room.lit_from(start);
    let mut changes: Vec<f64> = frames
        .windows(2)
        .flat_map(|pair| {
            let [(before, mean), (after, _)] = [&pair[0], &pair[1]];
            before.iter().zip(after).map(move |(a, b)| (b - a).abs() / mean)
        })
        .collect();
    changes.sort_by(f64::total_cmp);
    let square: f64 = changes.iter().map(|change| change * change).sum();
    ((square / changes.len() as f64).sqrt(), changes[changes.len() / 2])
}

#[test]
fn a_cut_flickers_less_than_kernels() {
    for (name, mut room) in [("boxes", Room::boxes(128)), ("columns", Room::columns(128))] {
        let count = 256;
        let (cut, cut_median) =
            flicker(&mut room, Emitter::Disc, &|room| lights(&room.map(), count));
        let [(wide, wide_median), (narrow, narrow_median)] = [1.0, 0.25]
            .map(|scale| flicker(&mut room, Emitter::Cosine, &|room| room.kernels(count, scale)));
        for (what, rms, median) in [
            ("cut", cut, cut_median),
            ("kernels, K 1", wide, wide_median),
            ("kernels, K 0.25", narrow, narrow_median),
        ] {
            println!("{name}, {what}: RMS {:.3} %, median {:.4} %", 100.0 * rms, 100.0 * median);
        }
        // The root mean square is that of a few pixels in corners, in which all are alike.
        assert!(cut_median < 0.5 * narrow_median && cut < 1.1 * narrow, "{name}");
    }
}
