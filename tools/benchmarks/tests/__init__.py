"""Tests of the benchmarks, without a device: python3 -m unittest discover -s tools/benchmarks/tests -t tools"""
