// The cage as OpenSubdiv has it, and what is to be known of it. Between the shim's own files: C++.

#ifndef CO_SHIMS_OSD_TOPOLOGY_HPP
#define CO_SHIMS_OSD_TOPOLOGY_HPP

#include "shims/osd.h"

#include <opensubdiv/far/topologyRefiner.h>

// NULL when OpenSubdiv refuses it. Throws what it throws.
OpenSubdiv::Far::TopologyRefiner *co_osd_refiner(const CoOsdDesc *desc);

// Whether somewhere two faces meet and yet have different limit normals.
bool co_osd_find_normal_seams(const OpenSubdiv::Far::TopologyLevel &cage);

// Whether the limit is only approached, the nearer the deeper features are isolated: at the end of
// an infinitely sharp crease, and where sharpness lasts for many levels.
bool co_osd_find_deep_features(const OpenSubdiv::Far::TopologyLevel &cage);

#endif
