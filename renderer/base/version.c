#include "cohort/base.h"

const char *cohort_version(void)
{
    return COHORT_VERSION;
}
