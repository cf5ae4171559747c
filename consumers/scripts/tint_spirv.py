"""Lets Tint's SPIR-V reader, and the validator in front of it, read SPIR-V files through Dawn's C interface.

    python tint_spirv.py LIST.json RESULT.json

LIST.json is an array of {"name", "file", "features", "entry_points": [{"name", "stage"}]}. RESULT.json receives
{"adapter", "driver", "versions", "results": [{"name", "state", "pipelines", "messages"}]}.
WebGPU in JavaScript takes WGSL alone, so this goes through the package dawn-python.
"""

import array
import ctypes
import importlib.metadata
import json
import os
import sys

from pydawn import utils, webgpu


def scoped(device, action):
    """What `action` returns, and the validation error it raises, if any."""
    webgpu.wgpuDevicePushErrorScope(device, webgpu.WGPUErrorFilter_Validation)
    value = action()
    errors = []
    callback = webgpu.WGPUPopErrorScopeCallbackInfo()
    callback.mode = webgpu.WGPUCallbackMode_WaitAnyOnly

    def popped(_status, kind, message, *_user):
        if kind != webgpu.WGPUErrorType_NoError:
            errors.append(utils.from_wgpu_str(message).strip())

    callback.callback = webgpu.WGPUPopErrorScopeCallback(popped)
    utils.wait(webgpu.wgpuDevicePopErrorScopeF(device, callback))
    return value, errors


def shader_module(device, words):
    """A shader module of SPIR-V words."""
    source = webgpu.WGPUShaderSourceSPIRV()
    source.chain.sType = webgpu.WGPUSType_ShaderSourceSPIRV
    source.codeSize = len(words)
    source.code = (ctypes.c_uint32 * len(words))(*words)
    descriptor = webgpu.WGPUShaderModuleDescriptor()
    descriptor.nextInChain = ctypes.cast(
        ctypes.pointer(source), ctypes.POINTER(webgpu.struct_WGPUChainedStruct)
    )
    return webgpu.wgpuDeviceCreateShaderModule(device, descriptor)


def compute_pipeline(device, module, entry_point):
    """A compute pipeline with the layout that its shader implies."""
    descriptor = webgpu.WGPUComputePipelineDescriptor()
    descriptor.compute.module = module
    descriptor.compute.entryPoint = utils.to_wgpu_str(entry_point)
    return webgpu.wgpuDeviceCreateComputePipeline(device, descriptor)


def read(device, entry):
    """Tint's verdict on one file."""
    with open(entry["file"], "rb") as file:
        data = file.read()
    words = array.array("I")
    words.frombytes(data[: len(data) // 4 * 4])
    if sys.byteorder == "big":
        words.byteswap()
    module, messages = scoped(device, lambda: shader_module(device, words))
    pipelines = 0
    for point in entry["entry_points"] if not messages else []:
        if point["stage"] != "compute":
            continue
        name = point["name"]
        _, errors = scoped(device, lambda: compute_pipeline(device, module, name))
        messages += [f"{name}: {error}" for error in errors]
        pipelines += not errors
    state = "invalid" if messages else "valid"
    return {"name": entry["name"], "state": state, "pipelines": pipelines, "messages": messages}


def main():
    """Reads the list, writes the result."""
    source, target = sys.argv[1:]
    adapter = utils.request_adapter_sync(webgpu.WGPUPowerPreference_HighPerformance)
    # What the adapter has of the features that the modules may need.
    known = {
        "float32-filterable": webgpu.WGPUFeatureName_Float32Filterable,
        "shader-f16": webgpu.WGPUFeatureName_ShaderF16,
        "subgroups": webgpu.WGPUFeatureName_Subgroups,
    }
    features = {name: value for name, value in known.items() if webgpu.wgpuAdapterHasFeature(adapter, value)}
    device = utils.request_device_sync(adapter, list(features.values()))

    results = []
    with open(source, encoding="utf-8") as file:
        entries = json.load(file)
    for entry in entries:
        lacking = [name for name in entry.get("features", []) if name not in features]
        if lacking:
            message = f"the adapter lacks {', '.join(lacking)}"
            results.append({"name": entry["name"], "state": "skipped", "pipelines": 0, "messages": [message]})
        else:
            results.append(read(device, entry))

    info = webgpu.WGPUAdapterInfo()
    webgpu.wgpuAdapterGetInfo(adapter, info)
    report = {
        "adapter": f"{utils.from_wgpu_str(info.vendor)} {utils.from_wgpu_str(info.architecture)}",
        "driver": utils.from_wgpu_str(info.description),
        "versions": {
            "dawn-python": importlib.metadata.version("dawn-python"),
            "python": sys.version.split()[0],
        },
        "results": results,
    }
    with open(target, "w", encoding="utf-8") as file:
        json.dump(report, file, indent=2)
    sys.stdout.flush()
    # Dawn's objects outlive the interpreter's order of destruction.
    os._exit(0)


main()
