// Layers read before they are asked for, several at a time.
//
// When composition opens a layer, the layers that its sublayers, references and payloads name are
// most likely wanted next, and those that they name after that. They are read on all threads and
// wait until they are asked for; what was found wrong with a layer is reported only then, so that
// messages and the order of layers are the same as with one thread. What nobody asks for is
// dropped.

#ifndef CO_COMPOSE_READ_AHEAD_H
#define CO_COMPOSE_READ_AHEAD_H

#include "compose/composer.h"

// The one entry of a layer, by absolute path (a token); made at first need.
CoLayerFile *co_file_entry(CoComposer *c, const char *path);

// Reads what `file` leads to, unless there is one thread only or no two layers to read at once.
void co_read_ahead(CoComposer *c, const CoLayerFile *file);

// The layer of an entry: the one that waits (its messages are passed on now), else read now. NULL
// when it cannot be read.
CoLayer *co_read_ahead_take(CoComposer *c, CoLayerFile *file, CohortError *err);

// Frees what still waits.
void co_read_ahead_drop(CoComposer *c);

#endif
