/* Every function of include/gnomon/shadow/, as expressions of a, b, c (reals) in the dialect.
 *
 * Whoever includes this defines REAL(name, domain, value); WORD of a luint; PAIR and FOUR of a
 * struct of two or four reals, with its type and members. Domains (lanes.h) say which inputs are
 * made. */
#define INTEGER(name, domain, lint) REAL(name, domain, gn_to_real(lint))
/* 1 where it holds, else 0. */
#define MASK(name, domain, mask) REAL(name, domain, gn_select(mask, gn_splat(1.0f), gn_splat(0.0f)))

#define CONE(name, domain, cone)      PAIR(name, domain, gn_ray_cone, width, angle, cone)
#define VARIANCE(name, domain, pair)  PAIR(name, domain, gn_variance, mean, square, pair)
#define MOMENTS(name, domain, four)   FOUR(name, domain, gn_moments, b1, b2, b3, b4, four)
#define NONLINEAR(name, domain, four) FOUR(name, domain, gn_nonlinear, y1, y2, v2, xi4, four)
#define CORNER(name, domain, pair)    PAIR(name, domain, gn_light_corner, x, y, pair)
#define WEIGHTS(name, domain, three)  FOUR(name, domain, gn_light_weights, a, b, c, c, three)

/* dialect.h */
REAL(splat, ANY, gn_select(a < a, a, gn_splat(0.1f)))
INTEGER(splat_int, ANY, gn_splat_int(7) & gn_bits(a))
REAL(select, ANY, gn_select(a < b, a, c))
REAL(select_int, ANY, gn_from_bits(gn_select_int(a < b, gn_bits(a), gn_bits(c))))
REAL(unsigned, ANY, gn_to_real(gn_to_signed(gn_to_unsigned(gn_bits(a)) >> 3)))
REAL(and, ANY, gn_select(gn_and(a < b, b < c), a, c))
REAL(or, ANY, gn_select(gn_or(a < b, b < c), a, c))
REAL(not, ANY, gn_select(gn_not(a >= b), a, c))
REAL(xor, ANY, gn_select((a < b) != (b < c), a, c))
REAL(bits, ANY, gn_from_bits(gn_bits(a) ^ 0x00400000))
REAL(to_real, ANY, gn_to_real(gn_bits(a)))
REAL(to_int, INT, gn_to_real(gn_to_int(a)))
REAL(sqrt, ANY, gn_sqrt(a))
REAL(floor, ANY, gn_floor(a))
REAL(abs, ANY, gn_abs(a))
REAL(min, ANY, gn_min(a, b))
REAL(max, ANY, gn_max(a, b))
REAL(clamp, ANY, gn_clamp(a, b, c))
REAL(clamp_positive, ANY, gn_clamp_positive(a, gn_abs(b), gn_abs(b) + gn_abs(c)))
REAL(log2, NOT_NEGATIVE, gn_log2(a))
REAL(exp2, ANY, gn_exp2(a))
REAL(exp2_clamped, EXPONENT, gn_exp2(a))
REAL(exp2_inside, UNIT, gn_exp2_inside((a - b) * 126.0f))
REAL(atan, ANY, gn_atan(a))
REAL(tan, ANY, gn_tan(a))
REAL(tan_inside, UNIT, gn_tan(a * 0.785398f))

/* ray_cone.h */
REAL(spread, LENGTH, gn_ray_cone_spread(a, b))
CONE(propagate, LENGTH, gn_ray_cone_propagate(GN_MAKE_CONE(a, -b), c))
CONE(propagate_exact, LENGTH, gn_ray_cone_propagate_exact(GN_MAKE_CONE(a, -gn_atan(b)), c))
CONE(hit, LENGTH, gn_ray_cone_hit(GN_MAKE_CONE(a, b), c))
CONE(hit_edge_on, ANY, gn_ray_cone_hit(GN_MAKE_CONE(a, b), c))
CONE(reflect, LENGTH, gn_ray_cone_reflect(GN_MAKE_CONE(a, b), c))
CONE(ortho, ANY, gn_ray_cone_ortho(GN_MAKE_CONE(a, b)))
CONE(focus, LENGTH, gn_ray_cone_focus(GN_MAKE_CONE(a, b), c))
CONE(focus_exact, LENGTH, gn_ray_cone_focus_exact(GN_MAKE_CONE(a, b), c))
REAL(lod, LENGTH, gn_ray_cone_lod(a, b, c))
REAL(footprint, LENGTH, gn_ray_cone_footprint(a, b, c))
REAL(footprint_any, ANY, gn_ray_cone_footprint(a, b, c))
REAL(footprint_area, LENGTH, gn_ray_cone_footprint_area(a, b, c))
REAL(footprint_area_any, ANY, gn_ray_cone_footprint_area(a, b, c))
REAL(nearest_level, ANY, gn_to_real(gn_ray_cone_nearest_level(a)))
REAL(nearest_mip, ANY, gn_ray_cone_nearest_mip(a, gn_splat(11.0f)))

/* alpha.h */
REAL(raw, ANY, gn_alpha_raw(a))
REAL(test, ANY, gn_alpha_test(a, b))
REAL(saturate, UNIT, gn_alpha_saturate(a, b))
REAL(ramp, UNIT, gn_alpha_ramp(a, b, c, gn_splat(0.7f)))
REAL(ramp_any, ANY, gn_alpha_ramp(a, b, c, gn_splat(0.7f)))
REAL(accumulate, UNIT, gn_visibility_accumulate(a, b))
REAL(rescale, UNIT, gn_visibility_rescale(a, b))
REAL(depth, UNIT, gn_to_real(gn_optical_depth(a)))
REAL(depth_any, ANY, gn_to_real(gn_optical_depth(gn_clamp(a, gn_splat(0.0f), gn_splat(1.0f)))))
REAL(visibility, UNIT, gn_optical_visibility(gn_to_int(a * 4194304.0f)))

/* texel.h */
WORD(unorm16_code, ANY, gn_unorm16_code(a))
WORD(unorm16_pack, UNIT, gn_unorm16_pack(a, b))
REAL(unorm16_low, ANY, gn_unorm16_low(gn_real_word(a)))
REAL(unorm16_high, ANY, gn_unorm16_high(gn_real_word(a)))
WORD(half_code, ANY, gn_half_code(a))
WORD(half_pack, UNIT, gn_half_pack(a * 1e-4f, b))
REAL(half_value, ANY, gn_half_value(gn_real_word(a) & 0xffffu))
REAL(half_low, ANY, gn_half_low(gn_real_word(a)))
REAL(half_high, ANY, gn_half_high(gn_real_word(a)))
REAL(word_real, ANY, gn_word_real(gn_real_word(a) ^ 1u))

/* bilinear.h */
REAL(bilinear_base, ANY, gn_bilinear_base(a))
REAL(bilinear_fraction, LENGTH, gn_bilinear_fraction(a))
FOUR(bilinear_weights, UNIT, gn_bilinear, w00, w10, w01, w11, gn_bilinear_weights(a, b))
REAL(bilinear_blend, UNIT, gn_bilinear_blend(gn_bilinear_weights(a, b), a, b, c, a *c))

/* leak.h */
MASK(leak_unsure, UNIT, gn_leak_unsure(a, b * 0.49f))
MASK(leak_unsure_any, ANY, gn_leak_unsure(a, gn_splat(0.01f)))
MASK(leak_shadowed, ANY, gn_leak_shadowed(a))
MASK(leak_blocked, UNIT, gn_leak_blocked(a, b < c))
INTEGER(leak_state, UNIT, gn_leak_state(a < 0.5f, b < 0.5f, c < 0.5f))
MASK(leak_expands, ANY, gn_leak_expands(gn_bits(a) & 7, b < c))
MASK(leak_confirms, ANY, gn_leak_confirms(gn_bits(a) & 7, b < c))
MASK(leak_removable, UNIT, gn_leak_removable(a))
REAL(leak_jitter_x, ANY, gn_leak_jitter_x(gn_real_word(a)))
REAL(leak_jitter_y, ANY, gn_leak_jitter_y(gn_real_word(a)))

/* light_buffer.h */
CORNER(light_corner_parallel, ANY, gn_light_corner_parallel(a, b, c, a))
CORNER(light_corner_central, ANY, gn_light_corner_central(a, b, c, b, a))
CORNER(light_corner_central_near, UNIT, gn_light_corner_central(a, b, c, b, a))
WEIGHTS(light_weigh, ANY, gn_light_weigh(GN_MAKE_CORNERS(a, b, c)))
WEIGHTS(light_weigh_near, UNIT, gn_light_weigh(GN_MAKE_CORNERS(a, b, c)))
REAL(light_area, ANY, gn_light_area(GN_MAKE_WEIGHTS(a, b, c)))
MASK(light_side, ANY, gn_light_side(a, GN_MAKE_CORNER(b, c), GN_MAKE_CORNER(c, a)))
MASK(light_side_met, UNIT, gn_light_side(a - a, GN_MAKE_CORNER(b, c), GN_MAKE_CORNER(c, a)))
MASK(light_covers, ANY, gn_light_covers(GN_MAKE_CORNERS(a, b, c), GN_MAKE_WEIGHTS(c, a, b)))
MASK(light_covers_near, UNIT,
     gn_light_covers(GN_MAKE_CORNERS(a, b, c), gn_light_weigh(GN_MAKE_CORNERS(a, b, c))))
MASK(light_inside, ANY, gn_light_inside(GN_MAKE_WEIGHTS(c, a, b)))
MASK(light_inside_near, UNIT, gn_light_inside(gn_light_weigh(GN_MAKE_CORNERS(a, b, c))))
MASK(light_on_edge, ANY, gn_light_on_edge(GN_MAKE_WEIGHTS(c, a, b)))
MASK(light_on_edge_met, UNIT, gn_light_on_edge(GN_MAKE_WEIGHTS(a - a, a, b)))
REAL(light_ahead, UNIT, gn_light_ahead(a, b * 1e-7f, c, a, b, c, b, c * 1e-7f))
INTEGER(light_face, ANY, gn_light_face(a, b, c))
INTEGER(light_face_near, UNIT, gn_light_face(a - b, b - c, c - a))
INTEGER(light_level, ANY, gn_light_level(a))

/* depth.h */
REAL(depth_test, ANY, gn_depth_test(a, b))

/* exponential.h */
REAL(exponential_warp, UNIT, gn_exponential_warp(a, b * 84.0f))
REAL(esm_of, UNIT, gn_esm_of(a, gn_splat(80.0f)))
REAL(esm_visibility, UNIT, gn_esm_visibility(gn_esm_of(a, b * 80.0f), b * 80.0f, c))
REAL(esm_visibility_any, ANY, gn_esm_visibility(a, b, c))

/* variance.h */
VARIANCE(variance_of, ANY, gn_variance_of(a))
REAL(chebyshev, UNIT, gn_chebyshev(a, b, gn_splat(1e-6f), c))
REAL(chebyshev_any, ANY, gn_chebyshev(a, b, a, c))
REAL(vsm_visibility, UNIT, gn_vsm_visibility(gn_variance_of(a), b * 1e-3f, c))
VARIANCE(evsm_positive_of, UNIT, gn_evsm_positive_of(a, b * 42.0f))
REAL(evsm_bound, UNIT, gn_evsm_bound(a, b, gn_splat(40.0f), gn_splat(1e-6f), c))
REAL(evsm_positive_visibility, UNIT,
     gn_evsm_positive_visibility(gn_evsm_positive_of(a, b * 42.0f), b * 42.0f, gn_splat(1e-6f), c))
FOUR(evsm_of, UNIT, gn_evsm, positive, positive_square, negative, negative_square,
     gn_evsm_of(a, b * 42.0f, c * 42.0f))
REAL(evsm_visibility, UNIT,
     gn_evsm_visibility(gn_evsm_of(a, gn_splat(40.0f), b * 42.0f), gn_splat(40.0f), b * 42.0f,
                        gn_splat(1e-6f), c))

/* moments.h */
MOMENTS(moments_of, ANY, gn_moments_of(a))
MOMENTS(moments_bias, UNIT, gn_moments_bias(gn_moments_of(a), b, c, a))
MOMENTS(moments_bias_float, UNIT, gn_moments_bias_float(gn_moments_of(a), b))
MOMENTS(moments_bias_fixed, UNIT, gn_moments_bias_fixed(gn_moments_of(a), b))
FOUR(moments_quantize, UNIT, gn_moments_fixed, q1, q2, q3, q4,
     gn_moments_quantize(GN_MAKE_MOMENTS(a, b, c)))
MOMENTS(moments_dequantize, UNIT, gn_moments_dequantize(GN_MAKE_FIXED(a, b, c, a *b)))
FOUR(moments_support_of, UNIT, gn_moments_support, t, u, b, c,
     gn_moments_support_of(GN_MAKE_MOMENTS(a, b, c), b - c))
REAL(moments_support_visibility, UNIT,
     gn_moments_support_visibility(gn_moments_support_of(GN_MAKE_MOMENTS(a, b, c), b - c)))
REAL(hamburger_visibility, UNIT,
     gn_hamburger_visibility(GN_MAKE_MOMENTS(a, b, c), a *(1.0f - c) + b))
REAL(hamburger_visibility_any, ANY, gn_hamburger_visibility(GN_MAKE_MOMENTS(a, b, c), c))
REAL(hausdorff_visibility, UNIT,
     gn_hausdorff_visibility(GN_MAKE_MOMENTS(a, b, c), a *(1.0f - c) + b))
REAL(hausdorff_visibility_any, ANY, gn_hausdorff_visibility(GN_MAKE_MOMENTS(a, b, c), c))

/* moments_nonlinear.h */
NONLINEAR(nonlinear_of, UNIT, gn_nonlinear_of(GN_MAKE_MOMENTS(a, b, c)))
NONLINEAR(nonlinear_of_any, ANY, gn_nonlinear_of(GN_MAKE_MOMENTS(a, b, c)))
MOMENTS(nonlinear_moments, UNIT, gn_nonlinear_moments(GN_MAKE_NONLINEAR(a, b, c)))
REAL(nonlinear_visibility, UNIT,
     gn_nonlinear_visibility(GN_MAKE_NONLINEAR(a, b, c), a *(1.0f - c) + b))
REAL(nonlinear_visibility_any, ANY, gn_nonlinear_visibility(GN_MAKE_NONLINEAR(a, b, c), c))
REAL(log2_polynomial, NOT_NEGATIVE, gn_log2_polynomial(a))
REAL(xi4_warp, UNIT, gn_xi4_warp(a *b * 1e-3f))
REAL(xi4_warp_any, ANY, gn_xi4_warp(a))
REAL(xi4_unwarp, UNIT, gn_xi4_unwarp(a))
WORD(nonlinear_pack64_low, UNIT, gn_nonlinear_pack64(GN_MAKE_NONLINEAR(a, b, c)).low)
WORD(nonlinear_pack64_high, UNIT, gn_nonlinear_pack64(GN_MAKE_NONLINEAR(a, b, c)).high)
NONLINEAR(nonlinear_unpack64, ANY, gn_nonlinear_unpack64(gn_real_word(a), gn_real_word(b)))
WORD(nonlinear_pack32, UNIT, gn_nonlinear_pack32(GN_MAKE_NONLINEAR(a, b, c)))
WORD(nonlinear_pack32_any, ANY, gn_nonlinear_pack32(GN_MAKE_NONLINEAR(a, b, c)))
NONLINEAR(nonlinear_unpack32, ANY, gn_nonlinear_unpack32(gn_real_word(a)))

#undef MASK
#undef INTEGER
#undef CONE
#undef VARIANCE
#undef MOMENTS
#undef NONLINEAR
#undef CORNER
#undef WEIGHTS
