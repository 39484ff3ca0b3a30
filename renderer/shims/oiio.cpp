#include "shims/oiio_module.h"

#include "base/error.h"

#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cstring>
#include <exception>
#include <filesystem>
#include <memory>
#include <new>
#include <sstream>
#include <string>
#include <system_error>

struct CoOiioFile {
    std::unique_ptr<OIIO::ImageInput> input;
    uint32_t channels, tile;
};

namespace
{

constexpr uint64_t most_texels = uint64_t(1) << 28;

bool fail(CohortError *err, const char *path, const std::string &why)
{
    std::string text = why.empty() ? OIIO::geterror() : why;
    OIIO::geterror(); // what is left there belongs to nobody else
    std::replace(text.begin(), text.end(), '\n', ' ');
    co_error_set(err, CO_HERE, COHORT_ERROR_TEXTURE, "cannot use image: %s",
                 text.empty() ? "no reader takes it" : text.c_str());
    co_error_place(err, path, 0, 0, nullptr);
    return false;
}

// Runs `body`; no exception leaves.
template <typename Body> bool guarded(CohortError *err, const char *path, Body body)
{
    try {
        return body();
    } catch (const std::bad_alloc &) {
        return co_error_set(err, CO_HERE, COHORT_ERROR_OUT_OF_MEMORY, "out of memory for an image");
    } catch (const std::exception &e) {
        return fail(err, path, e.what());
    } catch (...) {
        return fail(err, path, "unknown failure");
    }
}

void copy_text(char *to, size_t size, const std::string &from)
{
    std::snprintf(to, size, "%s", from.c_str());
}

std::unique_ptr<OIIO::ImageInput> open_image(const char *path)
{
    // A pipe would be waited for, a device read without end.
    std::error_code unused;
    if (std::filesystem::exists(path, unused) && !std::filesystem::is_regular_file(path, unused))
        return nullptr;
    OIIO::ImageSpec config;
    config.attribute("oiio:UnassociatedAlpha", 1);
    return OIIO::ImageInput::open(path, &config);
}

bool describe(const char *path, const OIIO::ImageInput &input, CoOiioInfo *out, CohortError *err)
{
    const OIIO::ImageSpec &spec = input.spec();
    if (spec.width < 1 || spec.height < 1 || spec.nchannels < 1 || spec.depth > 1 || spec.deep ||
        uint64_t(spec.width) * uint64_t(spec.height) > most_texels)
        return fail(err, path, "it is empty, deep, a volume or larger than 2^28 texels");
    CoOiioInfo info = {};
    info.width = uint32_t(spec.width);
    info.height = uint32_t(spec.height);
    // Further channels of an image are no color; a fourth one is kept where it is alpha.
    info.channels = uint32_t(std::min(spec.nchannels, spec.alpha_channel == 3 ? 4 : 3));
    if (spec.nchannels == 4)
        info.channels = 4;
    info.is_8bit = spec.format.basetype == OIIO::TypeDesc::UINT8;
    copy_text(info.format, sizeof info.format, input.format_name());
    copy_text(info.color_space, sizeof info.color_space,
              spec.get_string_attribute("oiio:ColorSpace"));
    std::string wraps = spec.get_string_attribute("wrapmodes");
    size_t comma = wraps.find(',');
    copy_text(info.wrap_s, sizeof info.wrap_s,
              spec.get_string_attribute("wrapS", wraps.substr(0, comma)));
    copy_text(info.wrap_t, sizeof info.wrap_t,
              spec.get_string_attribute(
                  "wrapT", comma == std::string::npos ? wraps : wraps.substr(comma + 1)));
    info.has_chromaticities = spec.getattribute(
        "chromaticities", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 8), info.chromaticities);
    *out = info;
    return true;
}

bool image_info(const char *path, CoOiioInfo *out, CohortError *err)
{
    return guarded(err, path, [&] {
        auto input = open_image(path);
        return input ? describe(path, *input, out, err) : fail(err, path, "");
    });
}

bool read_image(const char *path, const CoOiioInfo *info, float *out, CohortError *err)
{
    return guarded(err, path, [&] {
        auto input = open_image(path);
        CoOiioInfo now;
        if (!input)
            return fail(err, path, "");
        if (!describe(path, *input, &now, err))
            return false;
        if (now.width != info->width || now.height != info->height ||
            now.channels != info->channels)
            return fail(err, path, "it has changed while it was read");
        if (!input->read_image(0, 0, 0, int(info->channels), OIIO::TypeFloat, out))
            return fail(err, path, input->geterror());
        return true;
    });
}

bool write_mips(const char *path, const CoOiioInfo *info, const float *texels,
                        uint32_t tile, CohortError *err)
{
    return guarded(err, path, [&] {
        OIIO::ImageSpec spec(int(info->width), int(info->height), int(info->channels),
                             OIIO::TypeFloat);
        OIIO::ImageBuf image(spec, const_cast<float *>(texels));
        OIIO::ImageSpec config;
        config.format = OIIO::TypeFloat;
        config.tile_width = config.tile_height = int(tile);
        config.tile_depth = 1;
        config.attribute("maketx:fileformatname", "openexr");
        config.attribute("maketx:filtername", "box");
        config.attribute("compression", "zip");
        std::ostringstream log;
        if (!OIIO::ImageBufAlgo::make_texture(OIIO::ImageBufAlgo::MakeTxTexture, image, path,
                                              config, &log))
            return fail(err, path, log.str());
        return true;
    });
}

CoOiioFile *open_file(const char *path, CohortError *err)
{
    std::unique_ptr<CoOiioFile> file;
    bool ok = guarded(err, path, [&] {
        file.reset(new CoOiioFile());
        file->input = OIIO::ImageInput::open(path);
        if (!file->input)
            return fail(err, path, "");
        const OIIO::ImageSpec &spec = file->input->spec();
        if (spec.tile_width < 1 || spec.tile_width != spec.tile_height || spec.nchannels < 1)
            return fail(err, path, "it has no square tiles");
        file->channels = uint32_t(spec.nchannels);
        file->tile = uint32_t(spec.tile_width);
        return true;
    });
    return ok ? file.release() : nullptr;
}

void close_file(CoOiioFile *file)
{
    guarded(nullptr, "", [&] {
        delete file;
        return true;
    });
}

bool level_size(CoOiioFile *file, uint32_t level, uint32_t *width, uint32_t *height,
                   uint32_t *channels, uint32_t *tile)
{
    return guarded(nullptr, "", [&] {
        OIIO::ImageSpec spec = file->input->spec(0, int(level));
        if (spec.width < 1 || spec.height < 1)
            return false;
        *width = uint32_t(spec.width);
        *height = uint32_t(spec.height);
        *channels = file->channels;
        *tile = file->tile;
        return true;
    });
}

bool read_tile(CoOiioFile *file, uint32_t level, uint32_t x, uint32_t y, float *out,
                  CohortError *err)
{
    return guarded(err, "", [&] {
        OIIO::ImageSpec spec = file->input->spec_dimensions(0, int(level));
        int x0 = spec.x + int(x * file->tile), y0 = spec.y + int(y * file->tile);
        int x1 = std::min(x0 + int(file->tile), spec.x + spec.width);
        int y1 = std::min(y0 + int(file->tile), spec.y + spec.height);
        OIIO::stride_t step = OIIO::stride_t(file->channels * sizeof(float));
        if (x0 >= x1 || y0 >= y1)
            return fail(err, "", "there is no such tile");
        if (!file->input->read_tiles(0, int(level), x0, x1, y0, y1, 0, 1, 0, int(file->channels),
                                     OIIO::TypeFloat, out, step, step * OIIO::stride_t(file->tile)))
            return fail(err, "", file->input->geterror());
        return true;
    });
}

} // namespace

extern "C" __attribute__((visibility("default"))) const CoOiioFunctions co_oiio_functions = {
    image_info, read_image, write_mips, open_file, close_file, level_size, read_tile};
