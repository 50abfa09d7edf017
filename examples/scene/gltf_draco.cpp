// SPDX-License-Identifier: MIT
#include "gltf_draco.hpp"

#include <draco/compression/decode.h>

#include <array>
#include <memory>
#include <stdexcept>
#include <string>

namespace demo {

DracoMesh decode_draco(std::span<const std::uint8_t> compressed) {
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(compressed.data()), compressed.size());
    draco::Decoder decoder;
    auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
    if (!decoded.ok())
        throw std::runtime_error("is damaged: Draco says: " + decoded.status().error_msg_string());
    const std::unique_ptr<draco::Mesh> source = std::move(decoded).value();
    DracoMesh mesh;
    mesh.indices.reserve(3 * source->num_faces());
    for (draco::FaceIndex face(0); face < source->num_faces(); ++face)
        for (const draco::PointIndex& corner : source->face(face))
            mesh.indices.push_back(corner.value());
    for (int i = 0; i < source->num_attributes(); ++i) {
        const draco::PointAttribute& attribute = *source->attribute(i);
        const int components = attribute.num_components();
        if (components < 1 || components > 4)
            continue;
        DracoMesh::Attribute& values = mesh.attributes[static_cast<int>(attribute.unique_id())];
        values.components = components;
        values.values.reserve(source->num_points() * static_cast<std::size_t>(components));
        for (draco::PointIndex point(0); point < source->num_points(); ++point) {
            std::array<float, 4> value{};
            attribute.ConvertValue<float>(attribute.mapped_index(point), static_cast<std::int8_t>(components),
                                          value.data());
            values.values.insert(values.values.end(), value.begin(), value.begin() + components);
        }
    }
    return mesh;
}

}  // namespace demo
