/* Every function of include/gnomon/shadow/, as expressions of a, b, c (reals) in the dialect.
 *
 * REAL(name, domain, value) and CONE(name, domain, cone) are defined by whoever includes this;
 * cones carry their angle in a second value. Domains (lanes.h) say which inputs are made. */

/* dialect.h */
REAL(splat, ANY, gn_select(a < a, a, gn_splat(0.1f)))
REAL(select, ANY, gn_select(a < b, a, c))
REAL(and, ANY, gn_select(gn_and(a < b, b < c), a, c))
REAL(or, ANY, gn_select(gn_or(a < b, b < c), a, c))
REAL(not, ANY, gn_select(gn_not(a >= b), a, c))
REAL(bits, ANY, gn_from_bits(gn_bits(a) ^ 0x00400000))
REAL(to_real, ANY, gn_to_real(gn_bits(a)))
REAL(to_int, INT, gn_to_real(gn_to_int(a)))
REAL(sqrt, ANY, gn_sqrt(a))
REAL(floor, ANY, gn_floor(a))
REAL(abs, ANY, gn_abs(a))
REAL(min, ANY, gn_min(a, b))
REAL(max, ANY, gn_max(a, b))
REAL(clamp, ANY, gn_clamp(a, b, c))
REAL(log2, NOT_NEGATIVE, gn_log2(a))
REAL(exp2, ANY, gn_exp2(a))
REAL(exp2_inside, EXPONENT, gn_exp2(a))
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
