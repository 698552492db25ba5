use aghf::plan::Sampler;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

const ENDS: [&[f64]; 2] = [&[0.0, 0.5, -1.0], &[1.0, 0.0, -1.0]];

fn distance(a: &[f64], b: &[f64]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b));
    squares.sum::<f64>().sqrt()
}

/// The length of the path between the ends through each of many samples.
fn lengths(sampler: &Sampler<'_>) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut q = [0.0; 3];
    let length = |_| {
        sampler.sample(&mut q, &mut rng);
        for (q, [least, most]) in q.iter().zip(&sampler.ranges) {
            assert!((least..=most).contains(&q), "{q}");
        }
        distance(ENDS[0], &q) + distance(&q, ENDS[1])
    };
    (0..4000).map(length).collect()
}

/// With a known path every sample is on one that is no longer, and they fill the spheroid evenly: half of them are
/// within the spheroid that has the same foci and half the volume.
#[test]
fn samples_are_on_shorter_paths() {
    let far = distance(ENDS[0], ENDS[1]);
    let length = 1.5 * far;
    let mut sampler = Sampler { ends: ENDS, ranges: vec![[-9.0, 9.0]; 3], shortest: Some(length) };
    let all = lengths(&sampler);
    assert!(all.iter().all(|of| *of <= length * (1.0 + 1e-12)));
    // The volume is that of a ball times the product of the semi-axes, with one along the chord and two across it.
    let volume = |length: f64| length * (length * length - far * far);
    for share in [0.1, 0.5, 0.9] {
        let within = all.iter().filter(|of| volume(**of) <= share * volume(length));
        let found = within.count() as f64 / all.len() as f64;
        // Five standard deviations.
        let off = 5.0 * (share * (1.0 - share) / all.len() as f64).sqrt();
        assert!((found - share).abs() < off, "{share}: {found}");
    }
    sampler.ranges = vec![[-0.01, 1.2], [0.0, 0.7], [-1.0, -0.9]];
    let within = lengths(&sampler);
    assert!(within.iter().all(|of| *of <= length * (1.0 + 1e-12)));
}

/// Without one they fill the ranges.
#[test]
fn samples_fill_the_ranges() {
    let sampler = Sampler { ends: ENDS, ranges: vec![[-2.0, 4.0], [-1.0, 1.0], [-1.0, 0.0]], shortest: None };
    let all = lengths(&sampler);
    let longest = all.iter().copied().fold(0.0, f64::max);
    assert!(longest > 5.5, "{longest}");
}
