/* Takes back the words of dialect.h, so that an algorithm header leaves only gn_ names behind. */
#undef real
#undef lint
#undef luint
#undef mask
#undef K
#undef GN_FN
#undef GN_STRUCT
#undef GN_MAKE2
#undef GN_MAKE3
#undef GN_MAKE4
#undef GN_DIALECT_C
