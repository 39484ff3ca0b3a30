// Which prims and payloads of a stage are wanted at all.

#ifndef CO_COMPOSE_POPULATION_H
#define CO_COMPOSE_POPULATION_H

#include "compose/composer.h"

// Takes the options over: copies all they point to into the composer's arena and reads their paths.
// `root` is the root layer's, as it is given. Leaves by the composer's escape when memory is at an
// end; false when a path is none, *err says which.
bool co_population_init(CoComposer *c, const char *root, CohortError *err);

// False if the mask leaves the prim out. Prims above those of the mask are in.
bool co_population_includes(const CoComposer *c, const CoPath *path);

// True if the payloads of a prim of the stage are to come in.
bool co_population_loads(const CoComposer *c, const CoPath *path);

// Prims with the same answer, and the same sites, have the same of their descendants in.
uint64_t co_population_key(const CoComposer *c, const CoPath *path);

#endif
