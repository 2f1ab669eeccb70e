"""The commands as functions: samples to a field, a scan to a surface, a mesh to an audit."""

from fieldrecon.pipelines.block_averages import block_means

__all__ = ["block_means"]
