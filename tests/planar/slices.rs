//! Samples that follow a changing metric.

use crate::*;

/// A wave of size and direction that travels, a vortex that wanders, a wave of size alone.
#[test]
fn slices_follow_a_changing_metric() {
    follow(|t| {
        move |p: DVec2| {
            let angle = 0.6 * (TAU * p.x + t).sin() + 0.6 * (TAU * p.y).cos();
            let size = 1.0 + 0.5 * (TAU * (p.x - 0.5 * p.y) + t).sin();
            ellipse(angle, 2.0 * size, 0.5 * size)
        }
    });
    follow(|t| move |p: DVec2| vortex(p - 0.2 * DVec2::from_angle(t)));
    follow(|t| {
        move |p: DVec2| {
            let size = 1.0 + 0.6 * (TAU * p.x + 2.0 * t).sin() * (4.0 * p.y - t).cos();
            ellipse(0.0, size, size)
        }
    });
}

fn follow<M: PlanarMetric>(at: impl Fn(f64) -> M) {
    let domain = PlanarDomain::default();
    let sampling = PlanarSampling::count(5000);
    let mut slices = SliceSampler::new(&domain, &at(0.0), &sampling).expect("a good metric");
    let mut before: HashMap<u64, DVec2> = slices.ids().into_iter().zip(slices.samples().positions).collect();
    for slice in 1..=10 {
        let metric = at(0.1 * f64::from(slice));
        let report = slices.advance(&metric, 5).expect("a good metric");
        let samples = slices.samples();
        assert_sound(&samples);
        assert!(samples.len().abs_diff(5000) <= 50, "{} samples", samples.len());
        // The samples that stay are the same, and are near to where they were.
        let ids = slices.ids();
        let now: HashMap<u64, DVec2> = ids.iter().copied().zip(samples.positions.iter().copied()).collect();
        assert_eq!(now.len(), samples.len());
        let stayed = ids.iter().filter(|id| before.contains_key(id)).count();
        assert_eq!((stayed + report.inserted, stayed + report.removed), (5000, 5000));
        assert!(stayed > 4400 && report.rms_move < 0.5, "{report:?}");
        before = now;
        if slice % 3 != 1 {
            continue;
        }
        let [followed, fresh] = [
            quality(&metric, &samples),
            quality(&metric, &sample(&metric, &sampling)),
        ];
        assert!(
            followed.area_cv <= 1.1 * fresh.area_cv,
            "slice {slice}: {followed:?}, fresh {fresh:?}"
        );
    }
}

#[test]
fn slices_refuse_bad_input() {
    let domain = PlanarDomain::default();
    let few = SliceSampler::new(&domain, &isotropic, &PlanarSampling::count(3));
    assert!(matches!(few.err(), Some(PatternError::OutOfRange { .. })));
    let mut slices = SliceSampler::new(&domain, &isotropic, &PlanarSampling::count(300)).expect("a good metric");
    let before = slices.samples();
    let bad = |p: DVec2| isotropic(p) * if p.x > 0.5 { -1.0 } else { 1.0 };
    assert!(matches!(slices.advance(&bad, 5), Err(PatternError::NotPositive { .. })));
    assert_eq!(slices.samples(), before);
    // A world that changes altogether.
    slices.advance(&wavy(10.0), 30).expect("a good metric");
    assert_sound(&slices.samples());
    assert_eq!(slices.samples().len(), 300);
}

/// Where so few samples see a metric that jumps, flips of single edges would go round in a circle.
#[test]
fn flips_end_where_the_metric_jumps() {
    for seed in 0..4 {
        for (count, ratio) in [(100, 10.0), (300, 30.0), (1000, 100.0)] {
            let sampling = PlanarSampling {
                seed,
                ..PlanarSampling::count(count)
            };
            let mut slices = SliceSampler::new(&PlanarDomain::default(), &isotropic, &sampling).expect("a good metric");
            for metric in [wavy(ratio), wavy(1.0), wavy(ratio)] {
                slices.advance(&metric, 3).expect("a good metric");
                assert_sound(&slices.samples());
                let samples = slices.ids().into_iter().collect::<BTreeSet<u64>>().len();
                assert_eq!((samples, slices.samples().len()), (count as usize, count as usize));
            }
        }
    }
}
