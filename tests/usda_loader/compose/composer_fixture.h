// A composer for tests of what works on one.

#ifndef TEST_COMPOSER_FIXTURE_H
#define TEST_COMPOSER_FIXTURE_H

#include "compose/composer.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

static CoComposer composer;

static int begin(void **state)
{
    (void)state;
    composer = (CoComposer){0};
    return co_composer_init(&composer, NULL, NULL) ? 0 : -1;
}

static int end(void **state)
{
    (void)state;
    co_composer_clear(&composer);
    return 0;
}

#endif
