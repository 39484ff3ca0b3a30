// The OCIO config that Cohort carries, for when none is named: ACES CG v1.0.0 (data/aces-cg.ocio).

#ifndef CO_COLOR_SHIPPED_CONFIG_H
#define CO_COLOR_SHIPPED_CONFIG_H

// NUL-terminated text, generated from the file at build time.
extern const char co_shipped_config[];

#endif
