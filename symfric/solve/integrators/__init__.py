"""The route `integrators`: CasADi's own integrators."""
