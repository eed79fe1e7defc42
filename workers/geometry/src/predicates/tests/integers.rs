//! Integers of fixed width: arithmetic, and determinants at the limits of their widths.

use glam::{DVec2, DVec3};
use num_bigint::BigInt;

use super::samples::Samples;
use super::*;
use crate::predicates::integer::Row;
use crate::predicates::wide::Int;

fn big<const N: usize>(x: Int<N>) -> BigInt {
    let mut limbs: Vec<u8> = x.0.iter().flat_map(|limb| limb.to_le_bytes()).collect();
    limbs.push(if x.is_negative() { 0xff } else { 0 });
    BigInt::from_signed_bytes_le(&limbs)
}

/// Limbs that are random or extreme.
fn limbs<const N: usize>(samples: &mut Samples) -> Int<N> {
    Int([0; N].map(|_| match samples.below(6) {
        0 => 0,
        1 => u64::MAX,
        2 => 1 << 63,
        _ => samples.below(u64::MAX),
    }))
}

fn wrapped(x: &BigInt, limbs: u32) -> BigInt {
    let modulus = BigInt::from(1) << (64 * limbs);
    let half: BigInt = &modulus >> 1;
    ((x + &half) % &modulus + &modulus) % &modulus - half
}

fn check_products<const A: usize, const B: usize, const R: usize>(samples: &mut Samples) {
    for _ in 0..500 {
        let (a, b) = (limbs::<A>(samples), limbs::<B>(samples));
        assert_eq!(big(a.times::<B, R>(b)), wrapped(&(big(a) * big(b)), R as u32), "{a:?} {b:?}");
        let natural = BigInt::from_bytes_le(
            num_bigint::Sign::Plus,
            &b.0.iter().flat_map(|limb| limb.to_le_bytes()).collect::<Vec<u8>>(),
        );
        assert_eq!(big(a.times_natural::<B, R>(b)), wrapped(&(big(a) * natural), R as u32), "{a:?} {b:?}");
    }
}

#[test]
fn arithmetic_agrees_with_big_integers() {
    let samples = &mut Samples::new(1);
    check_products::<1, 1, 1>(samples);
    check_products::<1, 1, 2>(samples);
    check_products::<2, 1, 2>(samples);
    check_products::<2, 1, 3>(samples);
    check_products::<3, 2, 5>(samples);
    check_products::<2, 2, 4>(samples);
    check_products::<4, 2, 6>(samples);
    check_products::<6, 4, 10>(samples);
    for _ in 0..500 {
        let (a, b) = (limbs::<3>(samples), limbs::<3>(samples));
        assert_eq!(big(a.plus(b)), wrapped(&(big(a) + big(b)), 3));
        assert_eq!(big(a.minus(b)), wrapped(&(big(a) - big(b)), 3));
        let bits = samples.below(64) as u32;
        assert_eq!(big(a.shifted_down(bits)), big(a) >> bits);
        assert_eq!(a.sign(), exact::sign_of(&big(a)));
    }
}

/// A difference of `bits` bits, most often the largest one.
fn difference<const D: usize>(samples: &mut Samples, bits: u32) -> (Int<D>, BigInt) {
    let top = (BigInt::from(1) << bits) - 1;
    let size = match samples.below(4) {
        0 => BigInt::from(samples.below(3)),
        1 => top - samples.below(1000),
        _ => top,
    };
    let value = if samples.below(2) == 0 { size } else { -size };
    let mut bytes = value.to_signed_bytes_le();
    bytes.resize(8 * D, if value < BigInt::ZERO { 0xff } else { 0 });
    let limb = |i: usize| u64::from_le_bytes(bytes[8 * i..8 * i + 8].try_into().expect("8 bytes"));
    (Int(std::array::from_fn(limb)), value)
}

fn check_determinants<P: Point, const D: usize>(bits: u32, conflict: fn(&[Row<D>; 4]) -> Signs) {
    let samples = &mut Samples::new(u64::from(bits));
    let mut largest = 0;
    for _ in 0..2000 {
        let mut rows = [[Int([0; D]); 3]; 4];
        let mut values = Vec::new();
        for row in rows.iter_mut().take(P::DIM + 1) {
            let mut value = Vec::new();
            for x in row.iter_mut().take(P::DIM) {
                let (limbs, big) = difference(samples, bits);
                *x = limbs;
                value.push(big);
            }
            values.push(value);
        }
        let det = exact::in_sphere_of(values);
        largest = largest.max(det.bits());
        assert_eq!(conflict(&rows).det, exact::sign_of(&det), "{rows:?}");
    }
    // The bounds are nearly attained, except for the factor 72 (in the plane, 12).
    assert!(largest > u64::from(bits) * (P::DIM as u64 + 2), "{largest}");
}

#[test]
fn determinants_hold_at_the_ends_of_their_widths() {
    check_determinants::<DVec3, 1>(24, integer::conflict_narrow::<DVec3>);
    check_determinants::<DVec3, 1>(62, integer::conflict_single::<DVec3>);
    check_determinants::<DVec3, 2>(126, integer::conflict_double::<DVec3>);
    check_determinants::<DVec2, 1>(30, integer::conflict_narrow::<DVec2>);
    check_determinants::<DVec2, 1>(62, integer::conflict_single::<DVec2>);
    check_determinants::<DVec2, 2>(126, integer::conflict_double::<DVec2>);
}
